// vdbdiff: do two .vdb files hold the same grids, and if not, how far apart are they?
//
//   vdbdiff a.vdb b.vdb --max 1e-3 --topology 0.01
//
// Values are compared, not nodes or bytes: a tile is the voxels it covers, and how a file was made and packed does not
// matter. Exit status 0 within the tolerances, 3 beyond, 1 unreadable, 2 usage.
#include "app.h"

#include "vdbcloud/grid/compare.h"

#include <cmath>
#include <cstdio>
#include <limits>

using namespace vdbcloud;

namespace {

struct Options {
    std::string a, b;
    std::vector<std::string> grids;
    Tolerances allowed;
    app::Option max, rms, relative;
};

void declare(app::App& app, Options& o)
{
    app.reads_grids();
    app.add_option("a", o.a, "a .vdb, or - for standard input")->required();
    app.add_option("b", o.b, "another")->required();
    app.add_option("--grid", o.grids, "compare only this grid, NAME or NAME[k]; may be given again");
    const auto tolerance = "Tolerances";
    o.max = app.add_option("--max", o.allowed.max,
                           "largest difference of two values; any, if --rms or --relative is given alone")
                ->check(app::nonnegative)
                ->group(tolerance);
    o.rms = app.add_option("--rms", o.allowed.rms,
                           "root mean square of the differences over the active voxels; any, unless given")
                ->check(app::nonnegative)
                ->group(tolerance);
    o.relative = app.add_option("--relative", o.allowed.relative,
                                "that over the root mean square of the first file's values; any, unless given")
                     ->check(app::nonnegative)
                     ->group(tolerance);
    app.add_option("--topology", o.allowed.topology, "part of the voxels that may be active in one file alone")
        ->check(app::within(0, 1))
        ->group(tolerance);
    app.add_option("--transform", o.allowed.transform, "difference of the transforms, relative to their largest entry")
        ->check(app::nonnegative)
        ->group(tolerance);
    app.add_flag("--metadata", o.allowed.metadata,
                 "metadata has to be equal, but for creator, history and file statistics")
        ->group(tolerance);
}

/// What was not asked for is not a criterion: --rms 1e-3 alone says nothing of single values.
Tolerances criteria(const Options& o)
{
    const double anything = std::numeric_limits<double>::infinity();
    Tolerances allowed = o.allowed;
    if (!o.rms.given()) allowed.rms = anything;
    if (!o.relative.given()) allowed.relative = anything;
    if (!o.max.given() && (o.rms.given() || o.relative.given())) allowed.max = anything;
    return allowed;
}

/// JSON has no infinity.
nlohmann::json number(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json("infinite"); }

nlohmann::json described(const FileDifference& difference)
{
    nlohmann::json grids = nlohmann::json::array();
    for (const auto& d : difference.grids) {
        nlohmann::json grid = {{"name", d.label}, {"type", d.types}, {"comparable", d.comparable}};
        if (d.comparable)
            grid.update({{"by_value", d.by_value},
                         {"max", number(d.max)},
                         {"where", d.where},
                         {"rms", number(d.rms)},
                         {"relative", number(d.relative)},
                         {"voxels", d.voxels},
                         {"only_a", d.only_a},
                         {"only_b", d.only_b},
                         {"transform", number(d.transform)}});
        grid["metadata"] = d.metadata;
        grids.push_back(grid);
    }
    return {{"grids", grids},
            {"only_a", difference.only_a},
            {"only_b", difference.only_b},
            {"metadata", difference.metadata}};
}

/// One line a grid on standard error: standard output stays free for --json -.
void tell(app::App& app, const FileDifference& difference)
{
    for (const auto& d : difference.grids) {
        if (!d.comparable || !d.by_value) continue;
        char line[256];
        std::snprintf(line, sizeof line,
                      ": max %.6g at %d,%d,%d, rms %.6g, relative %.6g, active in one alone %llu of %llu", d.max,
                      d.where[0], d.where[1], d.where[2], d.rms, d.relative,
                      static_cast<unsigned long long>(d.only_a + d.only_b), static_cast<unsigned long long>(d.voxels));
        app.say("grid '" + printable(d.label) + "'" + line);
    }
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("vdbdiff", "Compare the grids of two .vdb files by value.");
    Options o;
    declare(app, o);

    return app.run(argc, argv, [&] {
        if (o.a == "-" && o.b == "-") throw UsageError("standard input cannot be both files");
        const GridFile a = app.read(o.a), b = app.read(o.b);
        if (app.dry_run()) return;
        const auto comparing = app.phase("compare");
        const FileDifference difference = compare_files(a, b, o.grids);
        const auto reasons = beyond(difference, criteria(o));
        app.report()["difference"] = described(difference);
        app.report()["beyond"] = reasons;
        tell(app, difference);
        if (reasons.empty()) return;
        const std::string more = reasons.size() == 1 ? "" : " (and " + std::to_string(reasons.size() - 1) + " more)";
        throw ConvergenceError(printable(o.a) + ", " + printable(o.b) + ": " + reasons.front() + more);
    });
}
