// cloudsim: cumulus convection after Kajiya and Von Herzen 1984, section 5.1. Condensed water is the density to render.
#include "report.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

using namespace vdbcloud;

namespace {

/// Starts from the sounding, or from the file of --init.
void start(app::App& app, const app::Options& o, sim::Simulation& sim)
{
    if (o.init.empty()) return sim.start();
    const sim::StartReport r = sim::start_from(sim, app.read(o.init), o.up);
    if (r.cells_set == 0) app.warnings()(o.init + ": no active voxel lies in the box, the air is the sounding's");
    if (r.negative_water > 0)
        app.warnings()(o.init + ": " + std::to_string(r.negative_water) + " cells with negative water were set to 0");
    std::ostringstream text;
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

void simulate(app::App& app, const app::Options& o, const app::Run& run)
{
    const sim::Preset& preset = run.preset;
    auto sim = sim::Simulation::make(preset.parameters, preset.sounding);
    const bool resumed = !o.resume.empty() && std::filesystem::exists(o.resume);
    const int last = resumed ? sim::read_checkpoint(o.resume, *sim, preset.sounding) : -1;
    if (!resumed) start(app, o, *sim);

    app::Log log(o.log, last);
    const sim::SnapshotOptions snapshot{o.up, o.unpruned, app::grid_names(o.grids), o.effective_radius,
                                        o.smoke_extinction};
    const auto progress = app.progress("simulate");
    bool warned = false, warned_speed = false;
    for (int n = last + 1; n <= run.frames; ++n) {
        sim->advance_to(run.time_of(n),
                        [&](double part) { return !progress || progress((n - 1 + part) / std::max(1, run.frames)); });
        const sim::Budget budget = sim->budget();
        if (run.sequence || n == run.frames) {
            GridFile file = sim::make_snapshot(*sim, snapshot, preset.sounding);
            app.write(app::frame_path(o.output, o.first_frame + n), file);
        }
        log.write(app::as_json(budget, n));
        app.say(app::as_line(budget, n));
        app.report()["accuracy"] = app::as_json(budget, n);
        judge_speed(app, budget, preset.parameters.lattice, warned_speed);
        judge(app, budget, o.strict, warned);
        if (!o.checkpoint.empty() && (n % o.checkpoint_every == 0 || n == run.frames))
            sim::write_checkpoint(o.checkpoint, *sim, preset.sounding, n);
    }
    app.report()["counts"] = {{"cells", preset.parameters.lattice.cells()},
                              {"frames", run.frames + 1},
                              {"steps", sim->budget().steps},
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
        if (app.dry_run()) return app::plan(app, run);
        if (run.sequence) make_folder_of(o.output);
        simulate(app, o, run);
    });
}
