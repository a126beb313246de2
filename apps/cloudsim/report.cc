#include "report.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

namespace vdbcloud::app {

namespace {

/// Steps of a run, by the limits of the first air and the speed of a lively cumulus: 15 m/s along all axes together.
double steps_of(const Run& run)
{
    const sim::Parameters& p = run.preset.parameters;
    const sim::Column column = sim::make_column(p, run.preset.sounding);
    double h = sim::never;
    for (const int axis : {0, 1, 2})
        if (!p.lattice.flat(axis)) h = std::min(h, p.lattice.h[size_t(axis)]);
    const double rate = std::max(p.momentum ? 15 / h : 0, sim::courant_rate_of(p, column));
    const bool huge = p.time_scheme == sim::TimeScheme::HugeStep;
    double step = huge ? sim::never : sim::step_limit(p, rate, p.momentum ? sim::frequency_of(p, column) : 0);
    if (p.dt > 0) step = std::min(step, p.dt);
    double steps = 0;
    const auto advance = [&](double seconds) {
        steps += seconds > 0 ? std::max(1.0, std::ceil(seconds / step - 1e-9)) : 0;
    };
    for (int n = 1; n <= run.frames; ++n) {
        const double from = run.time_of(n - 1), to = run.time_of(n), end = p.floor.until;
        if (from < end && end < to)
            advance(end - from), advance(to - end);
        else
            advance(to - from);
    }
    return steps;
}

/// Cell-steps a second and core, as bench_cloudsim measures them.
double speed_of(const sim::Parameters& p)
{
    if (p.time_scheme == sim::TimeScheme::HugeStep) return p.maccormack ? 0.15e6 : 0.4e6;
    return p.precision == sim::Precision::Double ? 4.5e6 : 8e6;
}

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
    for (const sim::RunValue& value :
         sim::describe(p, run.preset.sounding, plan_of(o, run, first_air_of(app, o))).values) {
        if (app.verbose()) app.say(value.name + " = " + value.value);
        app.report()["in_force"][value.name] = value.value;
    }
    const auto& [n, h, sides] = p.lattice;
    std::ostringstream box, cost;
    box << n[0] << " x " << n[1] << " x " << n[2] << " cells of " << h[0] << " x " << h[1] << " x " << h[2]
        << " m, z up, sides " << sim::side_words.word(sides[0]) << " in x and " << sim::side_words.word(sides[1])
        << " in y";
    app.say(box.str());
    const double steps = steps_of(run), bytes = double(sim::memory_needed(p));
    const double seconds = steps * double(p.lattice.cells()) / (speed_of(p) * app.threads());
    cost << run.seconds() << " s in " << run.frames << " frames, about " << steps
         << " steps: " << std::lround(bytes / 1e6) << " MB of fields, about " << std::lround(std::ceil(seconds))
         << " s on " << app.threads() << " threads";
    app.say(cost.str());
    app.report()["estimate"] = {{"memory_bytes", bytes}, {"seconds", seconds}, {"steps", steps}};
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

Log::Log(const std::string& path, int last) : path_(path)
{
    if (path.empty() || path == "-") return;
    std::string kept;
    if (last >= 0) {
        std::ifstream old(path);
        std::error_code none;
        if (!old && std::filesystem::exists(path, none)) throw IoError(path + ": cannot read the log");
        for (std::string line; std::getline(old, line);) {
            const auto entry = nlohmann::json::parse(line, nullptr, false);
            const auto frame = entry.is_object() ? entry.value("frame", nlohmann::json()) : nlohmann::json();
            if (frame.is_number() && frame.get<double>() <= last) kept += line + "\n";
        }
        if (old.bad()) throw IoError(path + ": cannot read the log");
    }
    AtomicFile whole(path);
    std::ofstream again(whole.name(), std::ios::binary);
    again << kept;
    again.close();
    if (!again) throw IoError(path + ": cannot write the log");
    whole.commit();
    file_.open(path, std::ios::app);
    if (!file_) throw IoError(path + ": cannot write the log");
}

void Log::write(const nlohmann::json& line)
{
    if (path_.empty()) return;
    std::ostream& out = path_ == "-" ? std::cout : file_;
    out << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
    if (!out) throw IoError(path_ + ": cannot write the log");
}

}  // namespace vdbcloud::app
