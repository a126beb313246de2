// vdbdiff: do two .vdb files hold the same grids, and if not, how far apart are they?
//
//   vdbdiff a.vdb b.vdb --max 1e-3 --topology 0.01
//
// Values are compared, not nodes or bytes: a tile is the voxels it covers, and how a file was made and packed does not
// matter. Exit status 0 within the tolerances, 3 beyond, 1 unreadable, 2 usage.
#include "report.h"

#include "vdbcloud/core/error.h"

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
    app.add_option("a", o.a, ".vdb, or - for standard input")->required()->reads_files();
    app.add_option("b", o.b, ".vdb to compare with the first, or - for standard input")->required()->reads_files();
    app.add_option(
        "--grid", o.grids,
        "compare this grid alone, NAME or NAME[k]; again for another; without it all grids, which have to be "
        "in both files");
    const auto tolerance = "Tolerances";
    o.max = app.add_option("--max", o.allowed.max,
                           "largest allowed difference of two values; any, if --rms or --relative is given alone")
                ->check(app::nonnegative)
                ->group(tolerance);
    o.rms = app.add_option("--rms", o.allowed.rms,
                           "largest allowed root mean square of the differences over the active voxels; any, unless "
                           "given")
                ->check(app::nonnegative)
                ->default_str("")
                ->group(tolerance);
    o.relative = app.add_option("--relative", o.allowed.relative,
                                "the same over the root mean square of the first file's values; any, unless given. Use "
                                "it for grids without a natural unit")
                     ->check(app::nonnegative)
                     ->default_str("")
                     ->group(tolerance);
    app.add_option("--topology", o.allowed.topology,
                   "largest allowed share of voxels that are active in one file alone")
        ->check(app::within(0, 1))
        ->group(tolerance);
    app.add_option("--transform", o.allowed.transform,
                   "largest allowed difference of the transforms, relative to their largest entry")
        ->check(app::nonnegative)
        ->group(tolerance);
    app.add_flag("--metadata", o.allowed.metadata,
                 "compare metadata, too, except creator, history and statistics of the file")
        ->group(tolerance);
    app.examples(
        {{"two files of equal values have status 0",
          "fractalgen --size 48 -o a.vdb && fractalgen --size 48 -o b.vdb && vdbdiff a.vdb b.vdb"},
         {"how far lattice and exact transmittance are apart; status 3 beyond the tolerances",
          "illuminate a.vdb --sun 0.3,1,0.2 -o l.vdb && illuminate a.vdb --sun 0.3,1,0.2 --fidelity exact -o e.vdb && "
          "vdbdiff l.vdb e.vdb --grid transmittance_sun --rms 0.02 --topology 0.1"},
         {"the differences of every grid, as JSON", "vdbdiff l.vdb e.vdb --max 1 --topology 1 --json -"}});
}

/// A tolerance that was not given is no criterion: --rms 1e-3 alone says nothing of single values.
Tolerances criteria(const Options& o)
{
    const double anything = std::numeric_limits<double>::infinity();
    Tolerances allowed = o.allowed;
    if (!o.rms.given()) allowed.rms = anything;
    if (!o.relative.given()) allowed.relative = anything;
    if (!o.max.given() && (o.rms.given() || o.relative.given())) allowed.max = anything;
    return allowed;
}

void compare(app::App& app, const Options& o)
{
    const GridFile a = app.read(o.a), b = app.read(o.b);
    if (app.dry_run()) return;
    const auto comparing = app.phase("compare");
    const FileDifference difference = compare_files(a, b, o.grids);
    const auto reasons = beyond(difference, criteria(o));
    app.report()["difference"] = described(difference);
    app.report()["beyond"] = reasons;
    print_difference(app, difference);
    if (reasons.empty()) return;
    const std::string more = reasons.size() == 1 ? "" : " (and " + std::to_string(reasons.size() - 1) + " more)";
    throw ConvergenceError(printable(o.a) + ", " + printable(o.b) + ": " + reasons.front() + more);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): only a wrong declaration throws outside run()
int main(int argc, char** argv)
{
    app::App app("vdbdiff", "Compares the grids of two .vdb files by value: status 0 within the tolerances, 3 beyond.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { compare(app, o); });
}
