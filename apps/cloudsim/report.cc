#include "report.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/sim/checkpoint.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/snapshot.h"
#include "vdbcloud/sim/step_plan.h"
#include "vdbcloud/sim/words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

namespace vdbcloud::app {

namespace {

/// What a run has still to do.
struct Rest {
    sim::CheckpointPlace from{-1, 0};  ///< of a run that continues; -1: a new one
    std::vector<double> times;         ///< of its frames, that of the start left out
};

/// Throws as read_checkpoint() does.
Rest rest_of(const Options& o, const Run& run, sim::RunRecord& record, bool resumed)
{
    Rest rest;
    sim::Schedule schedule{run.preset.every, run.seconds()};
    if (resumed) rest.from = sim::read_checkpoint_place(o.resume, record, schedule, o.change);
    for (int n = std::max(rest.from.frame + 1, 1); n <= schedule.last(); ++n) rest.times.push_back(schedule.time_of(n));
    return rest;
}

/// Values of one frame [bytes]. What fills the box, tables of trees too, is kept in `kept` of it; cloud, rain and dye
/// fill a small part of it.
double frame_bytes(const Options& o, const Run& run, double kept = 1)
{
    const sim::Parameters& p = run.preset.parameters;
    const auto names = grid_names(o.grids);
    const auto wanted = [&](const char* name) {
        return names.empty() || std::count(names.begin(), names.end(), name) > 0;
    };
    const double floats = (wanted("temperature") && (p.buoyancy || p.moisture)) + (wanted("qt") && p.moisture),
                 vectors = wanted("vel"), sparse = 1 + p.rain + p.dye + p.combustion.on;
    // The box is about the vertical axis: its trees have tables on four sides of it.
    const auto nodes = [&](double cells) { return std::ceil(cells / 128); };
    const auto& n = p.lattice.n;
    const TreeSize tables{0, 4 * nodes(n[0] / 2.0) * nodes(n[1] / 2.0) * nodes(n[2]), 4};
    const double cells = 4 * floats + 12 * vectors,
                 entries = tables.values(4) * (floats + sparse) + tables.values(12) * vectors;
    return double(p.lattice.cells()) * (kept * cells + 0.14 * 4 * sparse) + kept * entries;
}

/// Part of the box that is kept near clouds, in the mean over the frames of a cumulus preset.
constexpr double near_clouds_alone = 0.22;

void say_effects(App& app, const sim::Parameters& p)
{
    nlohmann::json list;
    for (const sim::Effect& e : sim::effects()) {
        const bool on = e.on(p);
        app.say((on ? "on   " : "off  ") + e.name + (on && !e.needs.empty() ? ": " + e.needs : ""));
        list[e.name] = on;
    }
    app.report()["effects"] = list;
}

}  // namespace

void plan(App& app, const Options& o, const Run& run)
{
    const sim::Parameters& p = run.preset.parameters;
    sim::check(p, run.preset.sounding);
    say_effects(app, p);
    const bool resumed = !o.resume.empty() && std::filesystem::exists(o.resume);
    const FirstAirFile air = first_air_of(app, o, resumed);
    sim::RunRecord record = sim::describe(p, run.preset.sounding, plan_of(o, run, air));
    const Rest rest = rest_of(o, run, record, resumed);
    for (const std::string& change : record.changes) app.say(change);
    for (const sim::RunValue& value : record.values) {
        if (app.verbose())
            app.say(value.name + " = " + value.value + (value.can_change ? "  (or another by --change)" : ""));
        app.report()["in_force"][value.name] = value.value;
    }
    const auto& [n, h, sides] = p.lattice;
    std::ostringstream box;
    box << n[0] << " x " << n[1] << " x " << n[2] << " cells of " << h[0] << " x " << h[1] << " x " << h[2]
        << " m, z up, sides " << sim::side_words.word(sides[0]) << " in x and " << sim::side_words.word(sides[1])
        << " in y";
    app.say(box.str());
    const auto start = [&](sim::Simulation& pilot) {
        if (!air.grids) return pilot.start();
        sim::start_from(pilot, *air.grids, o.up);
    };
    Plan needs = least_plan(o, run);
    // The pilot begins at time 0; the steps up to the checkpoint are done.
    const double reached = rest.from.time;
    const auto steps_to = [&](std::vector<double> times) {
        if (reached > 0) times.insert(times.begin(), reached);
        return sim::expected_steps(p, run.preset.sounding, times, start);
    };
    const double steps = rest.times.empty() ? 0 : steps_to(rest.times) - (reached > 0 ? steps_to({}) : 0);
    const double frames = double(rest.times.size()) + !resumed, written = run.sequence ? frames : 1;
    needs.work = sim::simulation_work(p, steps, frames);
    const bool near_clouds = p.moisture && !o.unpruned;
    if (!o.series.empty() || !o.profiles.empty()) needs.work.add("sim_sample_cell", frames * double(p.lattice.cells()));
    needs.work.add("write_byte", written * frame_bytes(o, run, near_clouds ? near_clouds_alone : 1));
    app.report()["estimate"]["steps"] = steps;
    tell(app, needs,
         "simulate " + brief(run.seconds() - reached) + " s in " + std::to_string(rest.times.size()) +
             " frames and about " + brief(steps) + " steps" +
             (resumed ? ", from " + o.resume + " at " + brief(reached) + " s on" : ""));
}

Plan least_plan(const Options& o, const Run& run)
{
    Plan plan;
    plan.bytes = double(sim::memory_needed(run.preset.parameters)) + frame_bytes(o, run);
    plan.way_out = "fewer --cells";
    return plan;
}

nlohmann::json as_json(const sim::Budget& b, int frame)
{
    return {{"frame", frame},
            {"time", b.time},
            {"steps", b.steps},
            {"retries", b.retries},
            {"dt", b.dt},
            {"cfl", b.courant},
            {"w_max", b.w_max},
            {"speed_max", b.speed_max},
            {"cloud_base", b.cloud_base},
            {"cloud_top", b.cloud_top},
            {"cloud_max", b.cloud_max},
            {"cloud_mean", b.cloud_mean},
            {"water_mean", b.water_mean},
            {"water_drift", b.water_drift},
            {"water_min", b.water_min},
            {"water_max", b.water_max},
            {"theta_mean", b.theta_mean},
            {"theta_drift", b.theta_drift},
            {"theta_min", b.theta_min},
            {"theta_max", b.theta_max},
            {"divergence", b.divergence},
            {"new_extrema", b.new_extrema},
            {"water_corrected", b.water_corrected},
            {"rain_fallen", b.rain_fallen},
            {"kinetic", b.kinetic},
            {"dye_mean", b.dye_mean},
            {"dye_drift", b.dye_drift},
            {"fuel_mean", b.fuel_mean},
            {"fuel_drift", b.fuel_drift},
            {"fault", b.fault}};
}

std::string as_line(const sim::Budget& b, int frame)
{
    char text[256], cloud[64] = "no cloud";
    if (b.cloud_base >= 0) std::snprintf(cloud, sizeof cloud, "cloud %.0f..%.0f m", b.cloud_base, b.cloud_top);
    std::snprintf(text, sizeof text,
                  "frame %d  %.1f s  dt %.3g s  cfl %.2f  w %.2f m/s  %s  water %+.1e  heat %+.1e  div %.1e", frame,
                  b.time, b.dt, b.courant, b.w_max, cloud, b.water_drift, b.theta_drift, b.divergence);
    return text;
}

LineFile::LineFile(const std::string& path, const std::string& what,
                   const std::function<bool(const std::string&)>& keep)
    : path_(path), what_(what)
{
    if (path.empty() || path == "-") return;
    std::string kept;
    if (keep) {
        std::ifstream old(path);
        std::error_code none;
        if (!old && std::filesystem::exists(path, none)) throw IoError(path + ": cannot read the " + what);
        for (std::string line; std::getline(old, line);)
            if (keep(line)) kept += line + "\n";
        if (old.bad()) throw IoError(path + ": cannot read the " + what);
    }
    AtomicFile whole(path);
    std::ofstream again(whole.name(), std::ios::binary);
    again << kept;
    again.close();
    if (!again) throw IoError(path + ": cannot write the " + what);
    whole.commit();
    file_.open(path, std::ios::app);
    if (!file_) throw IoError(path + ": cannot write the " + what);
}

void LineFile::write(const std::string& line)
{
    if (path_.empty()) return;
    std::ostream& out = path_ == "-" ? std::cout : file_;
    out << line << std::endl;
    if (!out) throw IoError(path_ + ": cannot write the " + what_);
}

namespace {

bool is_frame_up_to(int last, const std::string& line)
{
    const auto entry = nlohmann::json::parse(line, nullptr, false);
    const auto frame = entry.is_object() ? entry.value("frame", nlohmann::json()) : nlohmann::json();
    return frame.is_number() && frame.get<double>() <= last;
}

}  // namespace

Log::Log(const std::string& path, int last)
    : file_(path, "log", [last](const std::string& line) { return last >= 0 && is_frame_up_to(last, line); })
{
}

void Log::write(const nlohmann::json& line)
{
    file_.write(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace vdbcloud::app
