// A program built on App that does nothing but what it is told, so that the contract of all programs can be tested.
#include "app.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <forward_list>
#include <fstream>
#include <iostream>
#include <new>
#include <thread>

using namespace vdbcloud;

namespace {

enum class Method { Cells, Steps };

struct Options {
    std::string input, output, act = "nothing", note, unit, colour;
    double density = 1.0 / 3.0;
    int count = 3;
    uint64_t seed = 7;
    Vec3d sun{0.3, 1, 0.2}, albedo{1, 1, 1};
    std::vector<Vec3d> lamps;
    std::vector<std::string> names;
    std::vector<double> widths{1, 0.1};
    bool haze = true, fast = false;
    Method method = Method::Cells;
    double step = 1;
    app::Option density_option, sun_option, width_option;
};

void declare(app::App& app, Options& o)
{
    app.add_option("input", o.input, "a file, or -")->reads_files();
    app.add_option("-o,--output", o.output, "what to write")->required()->rewrites_file(app::FileKind::Any);
    app.add_option("--act", o.act, "what to do");
    app.add_option("--note", o.note, "any text");
    o.density_option = app.add_option("--density", o.density, "a number above 0")->check(app::positive);
    app.add_option("--count", o.count, "a whole number")->check(app::within(0, 100));
    app.add_option("--seed", o.seed, "64 bits");
    o.sun_option = app.add_option("--sun", o.sun, "a direction");
    app.add_rgb("--albedo", o.albedo, "a colour")->check(app::within(0, 1));
    app.add_option("--lamp", o.lamps, "positions");
    app.add_option("--name", o.names, "texts");
    o.width_option = app.add_option("--width", o.widths, "numbers");
    app.add_flag("--haze,!--no-haze", o.haze, "on unless switched off");
    app.add_flag("--fast", o.fast, "off unless switched on");
    app.add_choice<Method>("--method", o.method, {{"cells", Method::Cells}, {"steps", Method::Steps}}, "how");
    app.add_option("--step", o.step, "a length")
        ->only_with([&o] { return o.method == Method::Steps; }, "--method steps");
    app.add_option("--unit", o.unit, "of --sun")->needs(o.sun_option);
    app.add_option("--colour", o.colour, "of the haze")->not_with([&o] { return !o.haze; }, "--no-haze");
}

[[noreturn]] void sleep_long(app::App& app)
{
    const Progress progress = app.progress("waiting");
    for (int k = 0;; ++k) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        report(progress, std::min(0.9, k * 0.01));
    }
}

/// The most threads that were ever inside a parallel loop at once.
int most_at_once()
{
    std::atomic<int> inside{0}, most{0};
    tbb::parallel_for(0, 64, [&](int) {
        const int now = ++inside;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        --inside;
    });
    return most;
}

/// Takes all memory that there is in small pieces, and more where an exception leaves it: as a tree of OpenVDB does,
/// which makes a list of its nodes when it is destroyed.
class Hoard {
public:
    void fill()
    {
        for (;;) pieces_.emplace_front();
    }
    ~Hoard() { pieces_.emplace_front(); }

private:
    std::forward_list<char> pieces_;
};

void act(app::App& app, const Options& o)
{
    const std::string& what = o.act;
    if (what == "input-error") throw InputError("w.vdb: no grid 'density'; it has: water");
    if (what == "io-error") throw IoError("x.vdb: cannot read it");
    if (what == "usage-error") throw UsageError("--sun 0,1,0: the light was computed with 1,0,0");
    if (what == "unconverged") throw ConvergenceError("residual 0.1 after 7 iterations: expected 1e-6");
    if (what == "cancelled") throw Cancelled();
    if (what == "no-memory") throw std::bad_alloc();
    if (what == "huge") {
        std::vector<char> all(size_t(1) << 46, 1);
    }
    if (what == "hoard") Hoard().fill();
    if (what == "int") throw 7;
    if (what == "silent") throw std::runtime_error("");
    if (what == "lines") throw InputError("first\nsecond \033[31mred " + std::string(100000, 'x'));
    if (what == "thread") {
        std::thread([] { throw InputError("in a thread"); }).join();
    }
    if (what == "warn") app.warnings()("2 negative values became 0");
    if (what == "sleep" || what == "pipe") {
        const AtomicFile half_done(o.output);
        app.say("sleeping");
        if (what == "sleep") sleep_long(app);
        for (;;) std::cout << std::string(65536, 'x') << std::flush;
    }
    if (what == "spin") {
        const AtomicFile half_done(o.output);
        for (volatile int k = 0;; k = k + 1) continue;
    }
    if (what == "copy") {
        GridFile file = app.read(o.input);
        app.write(o.output, file);
    }
    if (what == "given")
        app.report()["counts"] = {{"density", o.density_option.given()}, {"sun", o.sun_option.given()}};
    if (what == "text") app.say(o.sun_option.text() + " " + o.width_option.text());
    if (what == "undeclared") app::Option().given();
    o.width_option.check_effect(o.act != "narrow", "--act wide");
    if (what == "threads") app.report()["counts"]["threads_at_once"] = most_at_once();
    if (what == "say") app.say("hello");
    if (what == "steps") {
        const Progress progress = app.progress("steps");
        for (int k = 0; k <= 100; ++k) report(progress, k / 100.0);
    }
    if (what == "history") std::cout << app.history(o.note) << "\n";
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): only a wrong declaration throws outside run()
int main(int argc, char** argv)
{
    app::App app("echo_tool", "Does what it is told.");
    app.reads_grids();
    app.writes_grids();
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] {
        const auto acting = app.phase("act");
        act(app, o);
        if (o.output != "-" && o.act != "copy" && !app.dry_run()) std::ofstream(o.output) << "done\n";
    });
}
