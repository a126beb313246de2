// cloudsim: a cloud that grows.
//
//   cloudsim --minutes 20 --every 10s -o out/cumulus.%04d.vdb
//   cloudsim --preset paper -o paper.%04d.vdb
//   cloudsim --cells 256 --checkpoint run.state --resume run.state -o out/cumulus.%04d.vdb
//
// Cumulus convection after Kajiya and Von Herzen 1984, section 5.1: condensed water is the density to render.
#include "options.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/sim/checkpoint.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

using namespace vdbcloud;

namespace {

/// The path of frame `number`; a pattern without % is one path for all.
std::string frame_path(const std::string& pattern, int number)
{
    const size_t percent = pattern.find('%');
    if (percent == std::string::npos) return pattern;
    size_t end = percent + 1;
    while (end < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[end]))) ++end;
    if (end >= pattern.size() || pattern[end] != 'd' || pattern.find('%', end) != std::string::npos)
        throw UsageError("--output " + pattern + ": expected one number like %04d");
    const std::string width = pattern.substr(percent + 1, end - percent - 1);
    if (width.size() > 3) throw UsageError("--output " + pattern + ": expected a number of up to 99 digits");
    std::string digits = std::to_string(number);
    const size_t least = width.empty() ? 0 : size_t(std::stoi(width));
    while (digits.size() < least) digits = (width[0] == '0' ? "0" : " ") + digits;
    return pattern.substr(0, percent) + digits + pattern.substr(end + 1);
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

/// Where the JSON lines go. A run that goes on after frame `last` keeps the lines up to it, and writes later ones anew.
class Log {
public:
    Log(const std::string& path, int last) : path_(path)
    {
        if (path.empty() || path == "-") return;
        std::string kept;
        if (last >= 0) {
            std::ifstream old(path);
            for (std::string line; std::getline(old, line);) {
                const auto entry = nlohmann::json::parse(line, nullptr, false);
                if (entry.is_object() && entry.value("frame", last + 1) <= last) kept += line + "\n";
            }
        }
        AtomicFile whole(path);
        std::ofstream(whole.name()) << kept;
        whole.commit();
        file_.open(path, std::ios::app);
        if (!file_) throw IoError(path + ": cannot write the log");
    }
    void line(const nlohmann::json& line)
    {
        if (path_.empty()) return;
        std::ostream& out = path_ == "-" ? std::cout : file_;
        out << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
        if (!out) throw IoError(path_ + ": cannot write the log");
    }

private:
    std::string path_;
    std::ofstream file_;
};

void plan(app::App& app, const sim::Scene& scene, int frames)
{
    const sim::Parameters& p = scene.parameters;
    sim::check(p, scene.sounding);
    const double h = std::min({p.lattice.h[0], p.lattice.h[1], p.lattice.h[2]});
    const double dt = p.dt > 0 ? p.dt : p.cfl * h / 15;  // 15 m/s along all axes together: a lively cumulus
    const bool frame_steps = p.time_scheme == sim::TimeScheme::HugeStep && p.dt == 0;
    const double steps = frame_steps ? frames : std::ceil(60 * scene.minutes / dt);
    // Cell-steps a second and core, as bench_cloudsim measures them.
    const bool huge = p.time_scheme == sim::TimeScheme::HugeStep;
    const double rate = huge ? (p.maccormack ? 0.15e6 : 0.4e6) : p.precision == sim::Precision::Double ? 4.5e6 : 8e6;
    const double seconds = steps * double(p.lattice.cells()) / (rate * app.threads()),
                 bytes = double(sim::memory_needed(p));
    nlohmann::json list;
    for (const sim::Effect& e : sim::effects()) {
        const bool on = e.on(p);
        app.say((on ? "on   " : "off  ") + e.name + (on && !e.needs.empty() ? ": " + e.needs : ""));
        list[e.name] = on;
    }
    for (const auto& [name, value] : sim::describe(p, scene.sounding)) {
        if (app.verbose()) app.say(name + " = " + value);
        app.report()["in_force"][name] = value;
    }
    const auto& [n, spacing, sides] = p.lattice;
    const char* side_names[] = {"periodic", "walls", "open"};
    std::ostringstream text;
    text << n[0] << " x " << n[1] << " x " << n[2] << " cells of " << spacing[0] << " x " << spacing[1] << " x "
         << spacing[2] << " m, z up, sides " << side_names[int(sides[0])] << " in x and " << side_names[int(sides[1])]
         << " in y";
    app.say(text.str());
    text.str("");
    text << 60 * scene.minutes << " s in " << frames << " frames, about " << steps
         << " steps: " << std::lround(bytes / 1e6) << " MB of fields, about " << std::lround(std::ceil(seconds))
         << " s on " << app.threads() << " threads";
    app.say(text.str());
    app.report()["estimate"] = {{"memory_bytes", bytes}, {"seconds", seconds}, {"steps", steps}};
    app.report()["effects"] = list;
}

void initialise(app::App& app, const app::Options& o, sim::Simulation& sim)
{
    if (o.init.empty()) return sim.start();
    const GridFile file = app.read(o.init);
    const sim::StartReport r = sim::start_from(sim, file, o.y_up);
    if (r.cells_set == 0) app.warnings()(o.init + ": no active voxel lies in the box, the air is the sounding's");
    if (r.negative_water > 0)
        app.warnings()(o.init + ": " + std::to_string(r.negative_water) + " cells with negative water were set to 0");
    std::ostringstream text;
    text << "start: " << r.saturated << " cells hold cloud, whose latent heat of " << r.latent_heat
         << " K (mean over the box) is already in the temperature";
    app.say(text.str());
    app.report()["start"] = {{"saturated_cells", r.saturated}, {"latent_heat", r.latent_heat}};
}

void run(app::App& app, const app::Options& o)
{
    sim::Scene scene = app::resolve(o);
    const int frames = int(std::ceil(60 * scene.minutes / scene.every - 1e-9));
    if (60 * scene.minutes / scene.every > 1e6) throw UsageError("--every: expected at most a million frames");
    const bool sequence = o.output.find('%') != std::string::npos;
    frame_path(o.output, 0);
    if (!o.floor_map.empty())
        scene.parameters.floor.map = app::read_floor_map(app, o.floor_map, scene.parameters.lattice, o.y_up);
    if (!o.floor_map.empty() && scene.parameters.floor.heat == 0 && scene.parameters.floor.moisture == 0)
        app.warnings()("--floor-map multiplies fluxes that are 0: expected --heat-flux or --moisture-flux");
    if (app.dry_run()) return plan(app, scene, frames);
    if (sequence) {
        const auto folder = std::filesystem::path(o.output).parent_path();
        std::error_code error;
        if (!folder.empty()) std::filesystem::create_directories(folder, error);
        if (error) throw IoError(folder.string() + ": cannot make this folder: " + error.message());
    }

    auto sim = sim::Simulation::make(scene.parameters, scene.sounding);
    int first = -1;
    const bool resumed = !o.resume.empty() && std::filesystem::exists(o.resume);
    if (resumed)
        first = sim::read_checkpoint(o.resume, *sim, scene.sounding);
    else
        initialise(app, o, *sim);
    Log log(o.log, first);

    sim::FrameOptions frame;
    frame.y_up = o.y_up, frame.unpruned = o.unpruned;
    frame.effective_radius = o.effective_radius, frame.smoke_extinction = o.smoke_extinction;
    frame.grids = app::grid_names(o.grids);
    std::string parameters;
    for (const auto& [name, value] : sim::describe(scene.parameters, scene.sounding))
        parameters += name + " = " + value + "\n";

    auto progress = app.progress("simulate");
    const auto watched = [&](double at) { return !progress || progress(at); };
    nlohmann::json faults = nlohmann::json::array();
    bool warned = false;
    for (int n = first + 1; n <= frames; ++n) {
        const double time = std::min(60 * scene.minutes, n * scene.every);
        sim->advance_to(time, [&](double part) { return watched((n - 1 + part) / std::max(1, frames)); });
        const sim::Budget budget = sim->budget();
        if (sequence || n == frames) {
            GridFile file = sim::make_frame(*sim, frame, parameters);
            app.write(frame_path(o.output, o.first_frame + n), file);
        }
        log.line(as_json(budget, n));
        app.say(as_line(budget, n));
        app.report()["accuracy"] = as_json(budget, n);
        if (!budget.fault.empty()) {
            if (o.strict) throw ConvergenceError("after " + std::to_string(budget.time) + " s: " + budget.fault);
            if (!warned) app.warnings()("after " + std::to_string(budget.time) + " s: " + budget.fault);
            warned = true;
        }
        if (!o.checkpoint.empty() && (n % o.checkpoint_every == 0 || n == frames))
            sim::write_checkpoint(o.checkpoint, *sim, scene.sounding, n);
    }
    app.report()["counts"] = {{"cells", scene.parameters.lattice.cells()},
                              {"frames", frames + 1},
                              {"steps", sim->budget().steps},
                              {"field_bytes", sim->bytes()}};
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("cloudsim", "Cumulus convection: heat, water and air, whose condensed water is a density to render.");
    app::Options o;
    app::declare(app, o);
    return app.run(argc, argv, [&] { run(app, o); });
}
