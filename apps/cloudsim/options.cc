#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/sounding.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace vdbcloud::app {

namespace {

using sim::Parameters;

/// Declares options whose value goes into the parameters only if it was given.
class Overrides {
public:
    Overrides(App& app, Options& o, const char* group) : app_(app), o_(o), group_(group) {}

    Option number(const char* name, std::function<double&(Parameters&)> member, const char* help)
    {
        auto given = std::make_shared<std::optional<double>>();
        o_.overrides.push_back([given, member](Parameters& p) {
            if (*given) member(p) = **given;
        });
        keep_.push_back(given);
        return app_.add_option(name, *given, help)->group(group_);
    }
    /// A length of time, or `never`.
    void time(const char* name, std::function<double&(Parameters&)> member, const char* help)
    {
        auto given = std::make_shared<std::string>();
        o_.overrides.push_back([given, member, name](Parameters& p) {
            if (given->empty()) return;
            member(p) = *given == "never" ? sim::never : seconds_of(name, *given);
        });
        app_.add_option(name, *given, help)->group(group_);
    }
    Option flag(const std::string& name, std::function<bool&(Parameters&)> member, const char* help)
    {
        auto given = std::make_shared<std::string>();
        o_.overrides.push_back([given, member](Parameters& p) {
            if (!given->empty()) member(p) = *given == "on";
        });
        return app_.add_choice<std::string>("--" + name, *given, {{"on", "on"}, {"off", "off"}}, help)
            ->default_str("")
            ->group(group_);
    }
    template<typename E>
    void choice(const char* name, std::function<E&(Parameters&)> member,
                const std::vector<std::pair<std::string, E>>& choices, const char* help)
    {
        auto given = std::make_shared<std::string>();
        std::vector<std::pair<std::string, std::string>> words;
        for (const auto& [word, value] : choices) words.emplace_back(word, word);
        o_.overrides.push_back([given, member, choices](Parameters& p) {
            for (const auto& [word, value] : choices)
                if (word == *given) member(p) = value;
        });
        app_.add_choice<std::string>(name, *given, words, help)->default_str("")->group(group_);
    }

private:
    App& app_;
    Options& o_;
    const char* group_;
    std::vector<std::shared_ptr<std::optional<double>>> keep_;
};

#define PARAMETER(path) [](Parameters& p) -> decltype(auto) { return (p.path); }

void declare_effects(App& app, Options& o)
{
    Overrides effect(app, o, "Effects, each on or off; what is off costs nothing");
    effect.flag("momentum", PARAMETER(momentum),
                "off: the sounding's wind blows for ever, without pressure; walls have none");
    effect.flag("buoyancy", PARAMETER(buoyancy), "warm air rises");
    effect.flag("moisture", PARAMETER(moisture), "water, cloud, saturation");
    effect.flag("latent-heat", PARAMETER(moist.latent_heat), "condensation warms");
    effect.flag("vapour", PARAMETER(moist.vapour), "vapour is lighter than air");
    effect.flag("loading", PARAMETER(moist.loading), "cloud and rain water weigh");
    o.option.rain = effect.flag("rain", PARAMETER(rain), "after Kessler");
    effect.flag("anelastic", PARAMETER(anelastic), "density falls with height");
    effect.flag("dye", PARAMETER(dye), "a passive scalar, smoke");
    effect.flag("subgrid", PARAMETER(subgrid), "Smagorinsky mixing");
    effect.time("--friction-time", PARAMETER(friction_time), "drag -V/t, t a time as 600s or 10min; or never");
    effect.number("--viscosity", PARAMETER(viscosity), "of the air [m^2/s]")->check(nonnegative);
    effect.number("--diffusivity", PARAMETER(diffusivity), "of heat, water and dye [m^2/s]")->check(nonnegative);
    o.option.radiation =
        effect.number("--radiation", PARAMETER(radiation), "long-wave loss at cloud top [W/m^2]; 0: off")
            ->check(nonnegative);
    effect.number("--sponge", PARAMETER(sponge), "damping under the lid [1/s]; 0: off")->check(nonnegative);
    effect.time("--wind-relaxation", PARAMETER(wind_relaxation),
                "mean wind returns to the sounding's in this time; or never");
}

void declare_constants(App& app, Options& o)
{
    Overrides constant(app, o, "Constants");
    constant.choice<sim::SaturationBy>(
        "--saturation", PARAMETER(moist.by),
        {{"height", sim::SaturationBy::Height}, {"temperature", sim::SaturationBy::Temperature}},
        "A exp(-z/H) as in the paper, or by temperature and pressure");
    constant.number("--q-surface", PARAMETER(q_surface), "A [kg/kg]")->check(positive);
    constant.number("--q-scale-height", PARAMETER(q_scale_height), "H [m]; 0: height of the box / ln 10")
        ->check(nonnegative);
    constant.number("--gravity", PARAMETER(constants.g), "[m/s^2]")->check(nonnegative);
    constant.number("--theta0", PARAMETER(constants.theta0), "potential temperature of the base state [K]")
        ->check(positive);
    constant.number("--latent-heat-of", PARAMETER(constants.latent_heat), "condensation, L [J/kg]")->check(nonnegative);
    constant.number("--cp", PARAMETER(constants.cp), "[J/(kg K)]")->check(positive);
    constant.number("--r-dry", PARAMETER(constants.r_dry), "gas constant of dry air [J/(kg K)]")->check(positive);
    constant.number("--r-vapour", PARAMETER(constants.r_vapour), "of water vapour [J/(kg K)]")->check(positive);
    constant.number("--pressure", PARAMETER(constants.surface_pressure), "at the floor, if the sounding has none [Pa]")
        ->check(positive);
    constant.number("--rho0", PARAMETER(constants.rho0), "density of air at the floor [kg/m^3]")->check(positive);
    constant.number("--smagorinsky", PARAMETER(smagorinsky), "coefficient of sub-grid mixing")->check(nonnegative);
    constant.number("--radiation-kappa", PARAMETER(radiation_kappa), "absorption by cloud [m^2/kg]")
        ->check(nonnegative);
    constant.number("--sponge-depth", PARAMETER(sponge_depth), "fraction of the height")->check(within(1e-3, 1));
    constant.number("--side-relaxation", PARAMETER(side_relaxation), "open sides return to the sounding in [s] ...")
        ->check(positive);
    constant.number("--side-depth", PARAMETER(side_cells), "... within so many cells of them")->check(within(0, 1000));
}

void declare_forcing(App& app, Options& o)
{
    const auto group = "Air and forcing";
    app.add_option("--sounding", o.sounding, "a table (see data/soundings), or the name of one; else the preset's")
        ->group(group);
    app.add_option("--wind", o.wind, "U,V added to the sounding [m/s]")->group(group);
    app.add_option("--shear", o.shear, "its change with height, U,V [1/s]")->group(group);
    Overrides forcing(app, o, group);
    forcing.number("--heat-flux", PARAMETER(floor.heat), "of the whole floor [K m/s]");
    forcing.number("--moisture-flux", PARAMETER(floor.moisture), "of the whole floor [kg/kg m/s]")->check(nonnegative);
    forcing.time("--flux-until", PARAMETER(floor.until), "all fluxes end then, as 15min; or never");
    app.add_option("--floor-map", o.floor_map, "an image or .vdb whose values multiply the uniform fluxes")
        ->group(group);
    app.add_option("--patch", o.patches,
                   "x,y,radius,heat,moisture[,dye]: a round patch of floor instead of the preset's, "
                   "positions from the box's corner [m]; again for more")
        ->group(group);
    app.add_option("--bubble", o.bubbles,
                   "x,y,z,radius,height,kelvin,water[,dye]: a round place in the first air instead of "
                   "the preset's; again for more")
        ->group(group);
    app.add_flag("--no-forcing", o.no_forcing, "neither patches, bubbles nor fluxes of the preset")->group(group);
    forcing.number("--noise", PARAMETER(noise.theta), "amplitude of noise on the temperature [K]")->check(nonnegative);
    forcing.number("--noise-water", PARAMETER(noise.water), "on the water [kg/kg]")->check(nonnegative);
    forcing.number("--noise-below", PARAMETER(noise.below), "only below this height [m]");
    app.add_option("--seed", o.seed, "of the noise, a whole number; else the preset's")->group(group);
    app.add_option("--init", o.init, "start from the grids temperature, qt, vel of this .vdb where they are active")
        ->group(group);
}

void declare_numerics(App& app, Options& o)
{
    const auto group = "Accuracy";
    o.option.accuracy = app.add_choice<sim::Accuracy>("--accuracy", o.accuracy,
                                                      {{"fast", sim::Accuracy::Fast},
                                                       {"default", sim::Accuracy::Default},
                                                       {"accurate", sim::Accuracy::Accurate}},
                                                      "a choice of the following")
                            ->group(group);
    Overrides numeric(app, o, group);
    numeric.choice<sim::Precision>("--precision", PARAMETER(precision),
                                   {{"float", sim::Precision::Float}, {"double", sim::Precision::Double}},
                                   "of the fields");
    numeric.choice<sim::TimeScheme>(
        "--time-scheme", PARAMETER(time_scheme),
        {{"euler", sim::TimeScheme::Euler}, {"rk2", sim::TimeScheme::Rk2}, {"rk3", sim::TimeScheme::Rk3}},
        "order 1, 2, 3");
    numeric.choice<sim::ScalarScheme>("--scalars", PARAMETER(scalar_scheme),
                                      {{"upwind", sim::ScalarScheme::Upwind},
                                       {"koren", sim::ScalarScheme::Koren},
                                       {"limited5", sim::ScalarScheme::Limited5},
                                       {"plain5", sim::ScalarScheme::Plain5}},
                                      "transport of heat and water: order 1, 3 and 5 without new extrema, 5 with them");
    numeric.choice<sim::MomentumScheme>(
        "--momentum-scheme", PARAMETER(momentum_scheme),
        {{"upwind", sim::MomentumScheme::Upwind}, {"upwind5", sim::MomentumScheme::Upwind5}}, "order 1 or 5");
    numeric.number("--cfl", PARAMETER(cfl), "steps so that dt (|u|/dx + |v|/dy + |w|/dz) stays below this")
        ->check(within(1e-3, 0.75));
    numeric.number("--dt", PARAMETER(dt), "time step [s], split where it is above a limit; 0: as the limits allow")
        ->check(nonnegative);
    numeric.number("--dt-max", PARAMETER(dt_max), "never longer [s]")->check(positive);
    app.add_flag("--huge-dt", o.huge_dt,
                 "semi-Lagrangian steps of --dt, or a frame, whatever their length: stable, but "
                 "nothing is conserved")
        ->group(group);
    numeric.flag("maccormack", PARAMETER(maccormack), "--huge-dt of second order in space, for twice the time");
    numeric.flag("fix-budget", PARAMETER(fix_budget),
                 "--huge-dt gives what it loses of heat and water back to all cells");
}

void declare_output(App& app, Options& o)
{
    const auto group = "Time and output";
    app.add_option("--minutes", o.minutes, "of simulated time; else the preset's")->check(nonnegative)->group(group);
    app.add_option("--every", o.every, "time between frames, as 10s or 0.5min; else the preset's")->group(group);
    app.add_choice<bool>("--up", o.y_up, {{"y", true}, {"z", false}}, "axis that points up in the files")->group(group);
    app.add_option("--grids", o.grids, "which to write, of density,temperature,qt,vel,rain,dye; else all there are")
        ->group(group);
    app.add_flag("--unpruned", o.unpruned, "every voxel of every grid active, also where there is no cloud")
        ->group(group);
    app.add_option("--effective-radius", o.effective_radius, "of droplets, for the extinction [m]")
        ->check(positive)
        ->group(group);
    app.add_option("--smoke-extinction", o.smoke_extinction, "sigma_t at dye 1, without moisture [1/m]")
        ->check(positive)
        ->group(group);
    app.add_option("--first-frame", o.first_frame, "its number")->check(nonnegative)->group(group);
    app.add_option("--log", o.log, "a JSON line a frame into FILE, or - for standard output")
        ->configurable(false)
        ->group(group);
    app.add_option("--checkpoint", o.checkpoint, "keep the whole state in FILE")->configurable(false)->group(group);
    app.add_option("--checkpoint-every", o.checkpoint_every, "frames between checkpoints")
        ->check(positive)
        ->configurable(false)
        ->group(group);
    app.add_option("--resume", o.resume, "go on from the checkpoint in FILE; start anew if there is none")
        ->configurable(false)
        ->group(group);
    app.add_flag("--strict", o.strict, "end with status 3 when a budget leaves its tolerance")->group(group);
}

std::vector<double> list_of(const std::string& option, const std::string& text, size_t least, size_t most)
{
    const auto values = numbers(text);
    if (!values || values->size() < least || values->size() > most)
        throw UsageError(option + " " + text + ": expected " + std::to_string(least) +
                         (most > least ? " to " + std::to_string(most) : "") + " numbers between commas");
    return *values;
}

void resolve_box(const Options& o, Parameters& p)
{
    const sim::Lattice before = p.lattice;
    if (!o.cells.empty()) {
        const auto n = list_of("--cells", o.cells, 1, 3);
        if (n.size() == 2) throw UsageError("--cells " + o.cells + ": expected N, or NX,NY,NZ");
        for (const size_t d : {0, 1, 2}) {
            // One number is for the longest axis: the others keep their spacing's proportion.
            const int longest = *std::max_element(before.n.begin(), before.n.end());
            const double cells = n.size() == 3 ? n[d]
                                 : before.n[d] == longest || n[0] != std::floor(n[0])
                                     ? n[0]
                                     : std::max(1.0, std::round(n[0] * before.n[d] / longest));
            if (cells != std::floor(cells) || cells < 1 || cells > 4096)
                throw UsageError("--cells " + o.cells + ": expected whole numbers in 1..4096");
            p.lattice.n[d] = int(cells);
            // The box keeps its size; only --spacing changes it. A single cell keeps the others' spacing.
            if (p.lattice.n[d] > 1) p.lattice.h[d] = before.n[d] * before.h[d] / cells;
        }
    }
    if (!o.spacing.empty()) {
        const auto h = list_of("--spacing", o.spacing, 1, 3);
        if (h.size() == 2) throw UsageError("--spacing " + o.spacing + ": expected H, or DX,DY,DZ");
        for (const size_t d : {0, 1, 2}) p.lattice.h[d] = h[h.size() == 1 ? 0 : d];
    }
    if (!o.sides.empty()) {
        const size_t comma = o.sides.find(',');
        const std::string words[2] = {o.sides.substr(0, comma),
                                      comma == std::string::npos ? o.sides : o.sides.substr(comma + 1)};
        for (const size_t d : {0, 1}) {
            if (words[d] == "periodic")
                p.lattice.side[d] = sim::Side::Periodic;
            else if (words[d] == "wall")
                p.lattice.side[d] = sim::Side::Wall;
            else if (words[d] == "open")
                p.lattice.side[d] = sim::Side::Open;
            else
                throw UsageError("--sides " + o.sides + ": expected periodic, wall or open, once or for x,y");
        }
    }
    for (const int d : {0, 1, 2})
        if (!(p.lattice.h[size_t(d)] > 0)) throw UsageError("--spacing " + o.spacing + ": expected numbers above 0");
    sim::rescale_forcing(p, before);
}

}  // namespace

void declare(App& app, Options& o)
{
    app.writes_grids();
    app.add_option("-o,--output", o.output,
                   "numbered frames, as out/cloud.%04d.vdb; or one file, or -, for the last alone")
        ->required();
    app.add_option("--preset", o.preset,
                   "cumulus, congestus, stratocumulus, fog, smoke, or paper (10 x 10 x 20 cells, forward "
                   "differences, saturation by height)");
    declare_output(app, o);
    const auto box = "Box";
    app.add_option("--cells", o.cells,
                   "of the preset's box: N along its longest axis, or NX,NY,NZ with z up; 1 for a slice")
        ->group(box);
    app.add_option("--spacing", o.spacing, "of cells, H or DX,DY,DZ [m]; the box is cells times spacing")->group(box);
    app.add_option("--sides", o.sides, "periodic, wall or open; for x,y")->group(box);
    declare_effects(app, o);
    declare_forcing(app, o);
    declare_constants(app, o);
    declare_numerics(app, o);
}

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

std::vector<std::string> grid_names(const std::string& text)
{
    const std::vector<std::string> known{"density", "temperature", "qt", "vel", "rain", "dye"};
    std::vector<std::string> names;
    std::istringstream words(text);
    for (std::string name; std::getline(words, name, ',');) {
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw UsageError("--grids " + text +
                             ": expected density, temperature, qt, vel, rain or dye, between commas");
        names.push_back(name);
    }
    return names;
}

sim::Scene resolve(const Options& o)
{
    sim::Scene s;
    try {
        s = sim::scene(o.preset);
    } catch (const InputError& error) {
        throw UsageError(error.what());
    }
    Parameters& p = s.parameters;
    if (o.option.accuracy.given()) sim::apply(o.accuracy, p);
    resolve_box(o, p);
    if (o.no_forcing) p.floor = {}, p.bubbles.clear();
    for (const auto& set : o.overrides) set(p);
    if (o.huge_dt) p.time_scheme = sim::TimeScheme::HugeStep;
    if (p.rain && !p.moisture && !o.option.rain.given()) p.rain = false;  // what a preset has, moisture off takes along
    if (!p.moisture && !o.option.radiation.given()) p.radiation = 0;
    if (!o.patches.empty()) p.floor.patches.clear();
    for (const std::string& text : o.patches) {
        const auto v = list_of("--patch", text, 5, 6);
        p.floor.patches.push_back({{v[0], v[1]}, v[2], v[3], v[4], v.size() > 5 ? v[5] : 0});
    }
    if (!o.bubbles.empty()) p.bubbles.clear();
    for (const std::string& text : o.bubbles) {
        const auto v = list_of("--bubble", text, 7, 8);
        p.bubbles.push_back({{v[0], v[1], v[2]}, v[3], v[4], v[5], v[6], v.size() > 7 ? v[7] : 0});
    }
    if (!o.seed.empty() && read_whole(o.seed, p.noise.seed) != 0)
        throw UsageError("--seed " + o.seed + ": expected a whole number, 0 or above");
    if (!o.sounding.empty()) {
        std::ifstream file(o.sounding);
        const std::string name = o.sounding.substr(o.sounding.find_last_of('/') + 1);
        std::ostringstream text;
        if (file) text << file.rdbuf();
        s.sounding = file ? sim::read_sounding(name, text.str()) : sim::sounding_named(o.sounding);
    }
    if (!o.wind.empty() || !o.shear.empty()) {
        const auto w = o.wind.empty() ? std::vector<double>{0, 0} : list_of("--wind", o.wind, 2, 2);
        const auto shear = o.shear.empty() ? std::vector<double>{0, 0} : list_of("--shear", o.shear, 2, 2);
        sim::add_wind(s.sounding, w[0], w[1], shear[0], shear[1]);
    }
    for (const std::string& name : grid_names(o.grids))
        if (name == "rain" ? !p.rain : name == "dye" ? !p.dye : name == "qt" && !p.moisture)
            throw UsageError("--grids " + o.grids + ": this run has no " + name);
    if (o.minutes) s.minutes = *o.minutes;
    if (!o.every.empty()) s.every = seconds_of("--every", o.every);
    return s;
}

}  // namespace vdbcloud::app
