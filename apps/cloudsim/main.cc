// cloudsim: cumulus convection after Kajiya and Von Herzen 1984, section 5.1. Condensed water is the density to render.
#include "statistics.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/checkpoint.h"
#include "vdbcloud/sim/step_plan.h"

#include <algorithm>
#include <filesystem>
#include <list>
#include <map>
#include <sstream>

using namespace vdbcloud;

namespace {

/// Starts from the sounding, or from the file of --init.
void start(app::App& app, const app::Options& o, const app::FirstAirFile& air, sim::Simulation& sim)
{
    if (!air.grids) return sim.start();
    const sim::StartReport r = sim::start_from(sim, *air.grids, o.up);
    if (r.cells_set == 0) app.warnings()(o.init + ": no active voxel lies in the box, the air is the sounding's");
    if (r.negative_water > 0)
        app.warnings()(o.init + ": " + std::to_string(r.negative_water) + " cells with negative water were set to 0");
    std::ostringstream text;
    if (r.up != o.up || r.resampled || r.centred_wind)
        app.say(o.init + ": " + up_axis_words.word(r.up) + " is up" +
                (r.resampled ? ", resampled to the cells of the run" : "") +
                (r.centred_wind ? ", vel from the centres of voxels" : ""));
    text << "start: " << r.saturated << " cells hold cloud, whose latent heat of " << r.latent_heat
         << " K (mean over the box) is already in the temperature";
    app.say(text.str());
    app.report()["start"] = {{"saturated_cells", r.saturated}, {"latent_heat", r.latent_heat}};
}

void make_folder_of(const std::string& path)
{
    const auto folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error) throw IoError(folder.string() + ": cannot make this folder: " + error.message());
}

/// One warning for air so fast that its compression matters, which the equations neglect.
void judge_speed(app::App& app, const sim::Budget& budget, const sim::Lattice& lattice, bool& warned)
{
    constexpr double sound = 340;  // [m/s]
    if (warned || budget.speed_max <= 0.3 * sound) return;
    warned = true;
    const double h = *std::min_element(lattice.h.begin(), lattice.h.end());
    std::ostringstream text;
    text.precision(3);
    text << "after " << budget.time << " s: wind of " << budget.speed_max << " m/s is Mach " << budget.speed_max / sound
         << ": the equations neglect compression, which matters above Mach 0.3, and cells of " << h
         << " m need steps below " << h / budget.speed_max << " s";
    app.warnings()(text.str());
}

/// A budget out of its tolerance: the end of the run with --strict, else one warning for the first.
void judge(app::App& app, const sim::Budget& budget, bool strict, bool& warned)
{
    if (budget.fault.empty()) return;
    const std::string fault = "after " + std::to_string(budget.time) + " s: " + budget.fault;
    if (strict) throw ConvergenceError(fault);
    if (!warned) app.warnings()(fault);
    warned = true;
}

/// Marks of what this run writes, so that no other run mixes with it, and an end to what killed runs left there.
class Marks {
public:
    explicit Marks(const app::Options& o)
    {
        for (const std::string& path :
             {app::frame_path(o.output, 0), o.checkpoint, o.log, o.series, o.profiles, o.netcdf})
            if (!path.empty() && path != "-" && ordinary(path)) locks_.emplace_back(path);
        const auto folder = [](const std::string& path) { return std::filesystem::path(path).parent_path().string(); };
        remove_stale_temporaries(
            folder(o.output), [&](const std::string& name) { return app::frame_number(o.output, name).has_value(); });
        for (const std::string& path : {o.checkpoint, o.log, o.series, o.profiles})
            if (!path.empty() && path != "-")
                remove_stale_temporaries(folder(path), [&](const std::string& name) {
                    return name == std::filesystem::path(path).filename().string();
                });
    }

private:
    /// Not a device or a fifo.
    static bool ordinary(const std::string& path)
    {
        std::error_code failed;
        const auto status = std::filesystem::status(path, failed);
        return !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
    }

    std::list<RunLock> locks_;
};

/// Warns of frames beyond frame `last` that another run left where this run writes its own: a film of all would mix
/// them.
void tell_other_frames(app::App& app, const app::Options& o, int last)
{
    std::map<int, std::string> beyond;
    std::error_code failed;
    const auto folder = std::filesystem::path(o.output).parent_path();
    for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, failed)) {
        const std::string name = entry.path().filename().string();
        if (const auto number = app::frame_number(o.output, name);
            number && *number > o.first_frame + last && entry.is_regular_file(failed))
            beyond[*number] = name;
    }
    if (!beyond.empty())
        app.warnings()((folder.empty() ? "." : folder.string()) + ": " + std::to_string(beyond.size()) +
                       (beyond.size() == 1 ? " frame" : " frames") + " of an earlier run, " + beyond.begin()->second +
                       (beyond.size() == 1 ? "" : " to " + beyond.rbegin()->second) +
                       ", beyond the last of this run, " + std::to_string(o.first_frame + last) +
                       ": a film of all would mix two runs: remove them, or write to another folder");
}

void simulate(app::App& app, const app::Options& o, const app::Run& run)
{
    const sim::Preset& preset = run.preset;
    app::require_memory(app::least_plan(o, run));
    const Marks marks(o);
    const bool resumed = !o.resume.empty() && std::filesystem::exists(o.resume);
    app::FirstAirFile air = app::first_air_of(app, o, resumed);
    auto sim = sim::Simulation::make(preset.parameters, preset.sounding);
    const sim::FramePlan plan = app::plan_of(o, run, air);
    sim::RunRecord record = sim::describe(preset.parameters, preset.sounding, plan);
    sim::Schedule schedule{preset.every, run.seconds()};
    std::string state;
    const int last = resumed ? sim::read_checkpoint(o.resume, *sim, record, schedule, o.change, &state) : -1;
    app::StatisticsFiles statistics(o, run, resumed ? sim->time() : -1, state);
    for (const std::string& change : record.changes) app.say(change);
    if (!resumed) start(app, o, air, *sim);
    air = {};  // its memory is the run's

    const uint64_t before = sim->budget().steps + sim->budget().retries;
    app::Log log(o.log, last);
    const int frames = schedule.last();
    if (!run.sequence && frames > 0 && o.output != "-")
        app.say(o.output + " has no place for a number, as %04d: it will hold the last frame alone");
    if (run.sequence) tell_other_frames(app, o, frames);
    const auto progress = app.progress("simulate");
    bool warned = false, warned_speed = false;
    for (int n = last + 1; n <= frames; ++n) {
        sim->advance_to(schedule.time_of(n),
                        [&](double part) { return !progress || progress((n - 1 + part) / std::max(1, frames)); });
        const sim::Budget budget = sim->budget();
        if (run.sequence || n == frames) {
            GridFile file = sim::make_snapshot(*sim, plan.snapshot, record);
            app.write(app::frame_path(o.output, o.first_frame + n), file);
        }
        log.write(app::as_json(budget, n));
        if (statistics.wanted()) statistics.add(*sim, budget, n == frames);
        app.say(app::as_line(budget, n));
        app.report()["accuracy"] = app::as_json(budget, n);
        judge_speed(app, budget, preset.parameters.lattice, warned_speed);
        judge(app, budget, o.strict, warned);
        if (!o.checkpoint.empty() && (n % o.checkpoint_every == 0 || n == frames))
            sim::write_checkpoint(o.checkpoint, *sim, record, schedule, n, statistics.state());
    }
    statistics.finish(app.history(""));
    const sim::Budget done = sim->budget();
    Workload work = sim::simulation_work(preset.parameters, double(done.steps + done.retries - before), frames - last,
                                         double(sim->pressure_iterations()));
    if (statistics.wanted())
        work.add("sim_sample_cell", double(statistics.samples()) * double(preset.parameters.lattice.cells()));
    app.add_work(work);
    app.report()["counts"] = {{"cells", preset.parameters.lattice.cells()},
                              {"frames", frames + 1},
                              {"steps", sim->budget().steps},
                              {"samples", statistics.samples()},
                              {"pressure_iterations", sim->pressure_iterations()},
                              {"field_bytes", sim->bytes()}};
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("cloudsim", "Cumulus convection: heat, water and air, whose condensed water is a density to render.");
    app::Options o;
    app::declare(app, o);
    return app.run(argc, argv, [&] {
        const app::Run run = app::resolve(app, o);
        if (app.dry_run()) return app::plan(app, o, run);
        if (run.sequence) make_folder_of(o.output);
        simulate(app, o, run);
    });
}
