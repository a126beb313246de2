// From options to a run: the preset, what was given, and which of it has no effect.
#include "frames.h"
#include "options.h"
#include "shapes.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/file/text.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/large_scale.h"
#include "vdbcloud/sim/sounding.h"
#include "vdbcloud/sim/words.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <sstream>

namespace vdbcloud::app {

namespace {

using sim::Parameters;

constexpr uint64_t most_table_bytes = uint64_t(1) << 24;  // of soundings and forcings

std::vector<double> list_of(const std::string& option, const std::string& text, size_t least, size_t most)
{
    const auto values = numbers(text);
    if (!values || values->size() < least || values->size() > most)
        throw UsageError(option + " " + text + ": expected " + std::to_string(least) +
                         (most > least ? " to " + std::to_string(most) : "") + " numbers between commas");
    return *values;
}

/// One number is for the longest axis: the others keep the proportions of the preset's cells. The box keeps its size.
void set_cells(const std::string& text, const sim::Lattice& before, sim::Lattice& lattice)
{
    const auto n = list_of("--cells", text, 1, 3);
    if (n.size() == 2) throw UsageError("--cells " + text + ": expected N, or NX,NY,NZ");
    const int longest = *std::max_element(before.n.begin(), before.n.end());
    for (const size_t d : {0, 1, 2}) {
        const bool given = n.size() == 3 || before.n[d] == longest || n[0] != std::floor(n[0]);
        const double cells = given ? n[n.size() == 3 ? d : 0] : std::max(1.0, std::round(n[0] * before.n[d] / longest));
        if (cells != std::floor(cells) || cells < 1 || cells > 4096)
            throw UsageError("--cells " + text + ": expected whole numbers in 1..4096");
        lattice.n[d] = int(cells);
        // A single cell keeps the others' spacing.
        if (lattice.n[d] > 1) lattice.h[d] = before.n[d] * before.h[d] / cells;
    }
}

void set_sides(const std::string& text, sim::Lattice& lattice)
{
    const size_t comma = text.find(',');
    const std::string words[2] = {text.substr(0, comma), comma == std::string::npos ? text : text.substr(comma + 1)};
    const auto sides = sim::side_words.choices();
    for (const size_t d : {0, 1}) {
        const auto found =
            std::find_if(sides.begin(), sides.end(), [&](const auto& side) { return words[d] == side.first; });
        if (found == sides.end())
            throw UsageError("--sides " + text + ": expected " + sim::side_words.list() + ", once or for x,y");
        lattice.side[d] = found->second;
    }
}

void set_box(const Options& o, Parameters& p)
{
    const sim::Lattice before = p.lattice;
    if (!o.cells.empty()) set_cells(o.cells, before, p.lattice);
    if (!o.spacing.empty()) {
        const auto h = list_of("--spacing", o.spacing, 1, 3);
        if (h.size() == 2) throw UsageError("--spacing " + o.spacing + ": expected H, or DX,DY,DZ");
        for (const size_t d : {0, 1, 2}) p.lattice.h[d] = h[h.size() == 1 ? 0 : d];
        for (const double spacing : p.lattice.h)
            if (!(spacing > 0)) throw UsageError("--spacing " + o.spacing + ": expected numbers above 0");
    }
    if (!o.sides.empty()) set_sides(o.sides, p.lattice);
    sim::rescale_forcing(p, before);
}

void set_forcing(const Options& o, Parameters& p)
{
    if (!o.patches.empty()) p.floor.patches.clear();
    for (const std::string& text : o.patches) {
        const auto v = list_of("--patch", text, 5, 7);
        p.floor.patches.push_back({{v[0], v[1]}, v[2], v[3], v[4], v.size() > 5 ? v[5] : 0, v.size() > 6 ? v[6] : 0});
    }
    if (!o.bubbles.empty()) p.bubbles.clear();
    for (const std::string& text : o.bubbles) {
        const auto v = list_of("--bubble", text, 7, 8);
        p.bubbles.push_back({{v[0], v[1], v[2]}, v[3], v[4], v[5], v[6], v.size() > 7 ? v[7] : 0});
    }
    if (!o.seed.empty() && read_whole(o.seed, p.noise.seed) != 0)
        throw UsageError("--seed " + o.seed + ": expected a whole number, 0 or above");
}

/// Whether an option names a file. A folder is none: a name of ours may be that of a folder, too.
bool is_file(const std::string& path)
{
    std::error_code none;
    return std::filesystem::exists(path, none) && !std::filesystem::is_directory(path, none);
}

/// A file, or a name of the compiled-in tables.
void set_large_scale(const Options& o, sim::LargeScale& forcing)
{
    if (o.forcing.empty()) return;
    const std::string name = o.forcing.substr(o.forcing.find_last_of('/') + 1);
    const bool carries_wind = forcing.carries_wind;
    if (is_file(o.forcing))
        forcing = sim::read_large_scale(name, read_text(o.forcing, most_table_bytes, "forcing"));
    else
        forcing = o.forcing == "none" ? sim::LargeScale() : sim::large_scale_named(o.forcing);
    forcing.carries_wind = carries_wind;
}

void set_sounding(const Options& o, sim::Sounding& sounding)
{
    if (!o.sounding.empty()) {
        const std::string name = o.sounding.substr(o.sounding.find_last_of('/') + 1);
        sounding = is_file(o.sounding) ? sim::read_sounding(name, read_text(o.sounding, most_table_bytes, "sounding"))
                                       : sim::sounding_named(o.sounding);
    }
    const auto pair = [](const char* option, const std::string& text) {
        return text.empty() ? std::vector<double>{0, 0} : list_of(option, text, 2, 2);
    };
    const auto wind = pair("--wind", o.wind), shear = pair("--shear", o.shear);
    if (!o.wind.empty() || !o.shear.empty()) sim::add_wind(sounding, wind[0], wind[1], shear[0], shear[1]);
}

/// An option, what it needs of the parameters, and the option that gives it.
struct Need {
    const char* option;
    bool (*met)(const Parameters&);
    const char* wanted;
};

bool has_momentum(const Parameters& p) { return p.momentum; }
bool has_moisture(const Parameters& p) { return p.moisture; }
bool has_heat(const Parameters& p) { return p.buoyancy || p.moisture; }
bool has_buoyancy(const Parameters& p) { return p.buoyancy; }
bool by_height(const Parameters& p) { return p.moisture && p.moist.by == sim::SaturationBy::Height; }
bool by_temperature(const Parameters& p) { return p.moisture && p.moist.by == sim::SaturationBy::Temperature; }
bool has_smoke(const Parameters& p) { return p.dye && !p.moisture; }
bool has_noise(const Parameters& p) { return p.noise.theta > 0 || (p.noise.water > 0 && p.moisture); }
bool has_fluxes(const Parameters& p) { return p.floor.heat != 0 || (p.floor.moisture > 0 && p.moisture); }

const Need needs[] = {
    {"viscosity", has_momentum, "--momentum on"},
    {"friction-time", has_momentum, "--momentum on"},
    {"sponge", has_momentum, "--momentum on"},
    {"wind-relaxation", has_momentum, "--momentum on"},
    {"momentum-scheme", has_momentum, "--momentum on"},
    {"coriolis", has_momentum, "--momentum on"},
    {"friction-velocity", has_momentum, "--momentum on"},
    {"surface-drag", has_momentum, "--momentum on"},
    {"subsidence-of-wind", has_momentum, "--momentum on"},
    {"theta0", has_buoyancy, "--buoyancy on"},
    {"rain", has_moisture, "--moisture on"},
    {"radiation", has_moisture, "--moisture on"},
    {"latent-heat", has_moisture, "--moisture on"},
    {"vapour", has_moisture, "--moisture on"},
    {"loading", has_moisture, "--moisture on"},
    {"saturation", has_moisture, "--moisture on"},
    {"latent-heat-of", has_moisture, "--moisture on"},
    {"rho0", has_moisture, "--moisture on"},
    {"moisture-flux", has_moisture, "--moisture on"},
    {"water-exchange", has_moisture, "--moisture on"},
    {"heat-exchange", has_heat, "--buoyancy on or --moisture on"},
    {"noise-water", has_moisture, "--moisture on"},
    {"effective-radius", has_moisture, "--moisture on"},
    {"q-surface", by_height, "--saturation height"},
    {"q-scale-height", by_height, "--saturation height"},
    {"r-vapour", by_temperature, "--saturation temperature"},
    {"smoke-extinction", has_smoke, "--moisture off --dye on"},
    {"noise-below", has_noise, "--noise or --noise-water"},
    {"seed", has_noise, "--noise or --noise-water"},
    {"floor-map", has_fluxes, "--heat-flux or --moisture-flux"},
};

/// "wind" is the mean of the sounding's wind over the levels of the box.
void set_frame(const Options& o, const sim::Sounding& sounding, Parameters& p)
{
    if (o.frame_velocity.empty()) return;
    if (o.frame_velocity != "wind") {
        const auto v = list_of("--frame-velocity", o.frame_velocity, 2, 2);
        p.frame = {v[0], v[1]};
        return;
    }
    sim::check(p, sounding);
    const sim::Column column = sim::make_column(p, sounding);
    const auto mean = [](const std::vector<double>& of_levels) {
        return std::accumulate(of_levels.begin(), of_levels.end(), 0.0) / double(of_levels.size());
    };
    p.frame = {mean(column.u), mean(column.v)};
}

/// The options that turn an effect on, as one writes them.
std::string turned_on_by(const sim::Effect& effect)
{
    std::string text = effect.switches == 0 ? "--" + effect.turned_on_by : "";
    for (size_t i = 0; i < effect.switches; ++i) {
        const sim::Setting& setting = effect.settings[i];
        text += (i > 0 ? " or --" : "--") + setting.name;
        if (setting.kind == sim::Setting::Kind::Switch) text += " on";
    }
    return text;
}

/// Throws UsageError for the first option that was given and changes nothing.
void refuse_idle_options(const Options& o, const Parameters& p)
{
    for (const Need& need : needs) {
        const Option& option = o.option.at(need.option);
        // "off" where there is nothing to turn off says what is so.
        const bool off =
            option.given() && (option.text() == option.name() + " off" || option.text() == option.name() + " 0");
        option.check_effect(off || need.met(p), need.wanted);
    }
    for (const sim::Effect& effect : sim::effects())
        for (size_t i = effect.switches; i < effect.settings.size(); ++i)
            o.option.at(effect.settings[i].name).check_effect(effect.on(p), turned_on_by(effect));
    o.option.at("netcdf").check_effect(!o.series.empty() || !o.profiles.empty(), "--series or --profiles");
    o.option.at("first-frame").check_effect(bool(FramePattern::in("--output", o.output)), "a numbered --output");
    for (const std::string& name : grid_names(o.grids))
        if (name == "rain"    ? !p.rain
            : name == "dye"   ? !p.dye
            : name == "flame" ? !p.combustion.on
                              : name == "qt" && !p.moisture)
            throw UsageError("--grids " + o.grids + ": this run has no " + name);
}

}  // namespace

double seconds_of(const std::string& option, const std::string& text)
{
    size_t end = text.find_first_not_of("0123456789.eE+-");
    if (end == std::string::npos) end = text.size();
    const auto value = number(text.substr(0, end));
    std::string unit = text.substr(end);
    unit.erase(0, unit.find_first_not_of(' ') == std::string::npos ? unit.size() : unit.find_first_not_of(' '));
    const double scale = unit.empty() || unit == "s" ? 1 : unit == "min" || unit == "m" ? 60 : unit == "h" ? 3600 : 0;
    if (!value || !(*value > 0) || scale == 0)
        throw UsageError(option + " " + text + ": expected a time above 0, as 10s, 2min or 1h");
    return *value * scale;
}

std::string frame_path(const std::string& pattern, int number)
{
    const auto numbered = FramePattern::in("--output", pattern);
    return numbered ? numbered->path(number) : pattern;
}

std::optional<int> frame_number(const std::string& pattern, const std::string& name)
{
    const auto file = [&](int number) {
        return std::filesystem::path(frame_path(pattern, number)).filename().string();
    };
    const std::string first = file(0), second = file(1);
    if (first == second) return name == first ? std::optional(0) : std::nullopt;
    size_t begin = 0, end = 0;  // lengths of what surrounds the number
    while (first[begin] == second[begin]) ++begin;
    while (begin > 0 && std::isdigit(static_cast<unsigned char>(first[begin - 1]))) --begin;
    while (first[first.size() - 1 - end] == second[second.size() - 1 - end]) ++end;
    if (name.size() <= begin + end) return std::nullopt;
    int number = 0;
    const bool whole = read_whole(name.substr(begin, name.size() - begin - end), number) == 0 && number >= 0;
    return whole && file(number) == name ? std::optional(number) : std::nullopt;
}

FirstAirFile first_air_of(App& app, const Options& o, bool resumed)
{
    FirstAirFile air;
    if (o.init.empty()) return air;
    air.identity = "standard input";
    if (o.init == "-" && resumed) return air;
    air.grids = app.read(o.init);
    if (o.init != "-") air.identity = app.report()["inputs"].back()["digest"];
    return air;
}

sim::FramePlan plan_of(const Options& o, const Run& run, const FirstAirFile& air)
{
    sim::FramePlan plan;
    plan.snapshot = {o.up, o.unpruned, grid_names(o.grids), o.effective_radius,
                     o.smoke_extinction.value_or(run.preset.smoke_extinction)};
    plan.every = run.preset.every;
    plan.first_frame = o.first_frame;
    plan.init = air.identity;
    return plan;
}

std::vector<std::string> grid_names(const std::string& text)
{
    const std::vector<std::string> known{"density", "temperature", "qt", "vel", "rain", "dye", "flame"};
    std::vector<std::string> names;
    std::istringstream words(text);
    for (std::string name; std::getline(words, name, ',');) {
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw UsageError("--grids " + text +
                             ": expected density, temperature, qt, vel, rain, dye or flame, between commas");
        names.push_back(name);
    }
    return names;
}

Run resolve(App& app, const Options& o)
{
    Run run;
    try {
        run.preset = sim::preset(o.preset);
    } catch (const InputError& error) {
        throw UsageError(error.what());
    }
    Parameters& p = run.preset.parameters;
    if (o.option.at("accuracy").given()) sim::apply(o.accuracy, p);
    set_box(o, p);
    if (o.no_forcing) {
        p.floor = {}, p.surface = {}, p.large_scale = {}, p.coriolis = 0;
        p.bubbles.clear(), p.sources.clear();
    }
    for (const auto& set : o.overrides) set(p);
    if (o.huge_dt) p.time_scheme = sim::TimeScheme::HugeStep;
    // Rain and radiation of a preset end with its moisture.
    if (!p.moisture && !o.option.at("rain").given()) p.rain = false;
    if (!p.moisture && !o.option.at("radiation").given()) p.radiation = 0;
    // A preset's Coriolis force ends with the wind across a slice, and its geostrophic wind with that.
    if ((p.lattice.flat(0) || p.lattice.flat(1)) && !o.option.at("coriolis").given()) p.coriolis = 0;
    set_forcing(o, p);
    set_large_scale(o, p.large_scale);
    set_sounding(o, run.preset.sounding);
    set_frame(o, run.preset.sounding, p);
    if (o.minutes) run.preset.minutes = *o.minutes;
    if (!o.every.empty()) run.preset.every = seconds_of("--every", o.every);
    run.average = o.average.empty() ? std::max(run.seconds(), run.preset.every) : seconds_of("--average", o.average);
    refuse_idle_options(o, p);
    o.option.at("pressure").check_effect(!(run.preset.sounding.pressure > 0), "a sounding that has no pressure");

    const double frames = run.seconds() / run.preset.every;
    if (frames > 1e6) throw UsageError("--every: expected at most a million frames");
    run.frames = int(std::ceil(frames - 1e-9));
    run.sequence = bool(FramePattern::in("--output", o.output));
    p.colliders = colliders_of(app, o, p.lattice);
    if (!o.sources.empty()) p.sources = sources_of(app, o, p.lattice);
    if (!o.floor_map.empty()) p.floor.map = read_floor_map(app, o.floor_map, p.lattice, o.up);
    return run;
}

}  // namespace vdbcloud::app
