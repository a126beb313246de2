// vdbprobe: prints the values of grids at points of the world.
//
//   vdbprobe lit.vdb --grid phi --at 5,5,5 --at 5,15,5
//   vdbprobe lit.vdb --grid phi --grid flux --points points.txt > values.txt
//
// A line a point: x, y, z, then each grid's number, or its three numbers. The first line, after #, names the columns.
#include "app.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/table.h"
#include "vdbcloud/grid/probe.h"
#include "vdbcloud/grid/select.h"

#include <cstdio>

using namespace vdbcloud;

namespace {

struct Options {
    std::string input, points;
    std::vector<std::string> grids;
    std::vector<Vec3d> at;
};

void declare(app::App& app, Options& o)
{
    app.reads_grids();
    app.add_option("input", o.input, ".vdb, or - for standard input")->required()->reads_files();
    app.add_option("--grid", o.grids, "grid to read, NAME or NAME[k]; again for a further column")->required();
    app.add_vec3s("--at", o.at, "point x,y,z [world unit]; again for a further line");
    app.add_option("--points", o.points,
                   "a table of points, three numbers a line, which follow those of --at; - for standard input")
        ->type_name("FILE")
        ->reads_files();
    app.examples({{"the density in the middle of a cloud",
                   "fractalgen --size 48 -o cloud.vdb && vdbprobe cloud.vdb --grid density --at 0,0.5,0"},
                  {"fluence and flux along a line, as a table",
                   "p1solve cloud.vdb --sun 0,1,0 --albedo 0.99 --g 0.5 -o lit.vdb && "
                   "printf '0 0.2 0\\n0 0.4 0\\n0 0.6 0\\n' | vdbprobe lit.vdb --grid phi --grid flux --points - > "
                   "line.txt"},
                  {"the same as JSON", "vdbprobe lit.vdb --grid phi --at 0,0.5,0 --json -"}});
}

/// The points of --at, then those of --points.
std::vector<Vec3d> wanted_points(const Options& o)
{
    std::vector<Vec3d> all = o.at;
    if (o.points.empty() && all.empty()) throw UsageError("no point: expected --at or --points");
    if (o.points.empty()) return all;
    const Table table = read_table(o.points);
    if (table.columns != 3)
        throw InputError(printable(o.points) + ": rows of " + std::to_string(table.columns) +
                         " numbers: expected three, x y z");
    for (size_t row = 0; row < table.rows; ++row)
        all.emplace_back(table.at(row, 0), table.at(row, 1), table.at(row, 2));
    return all;
}

std::string text_of(double x)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", x);  // what a float holds
    return text;
}

/// Names of the columns: of a vector grid NAME.x, NAME.y, NAME.z.
std::string heading(const std::vector<GridBasePtr>& grids, const std::vector<std::string>& labels)
{
    std::string line = "# x y z";
    for (size_t k = 0; k < grids.size(); ++k) {
        const bool vector = value_at(*grids[k], Vec3d(0.0)).components.size() == 3;
        for (const char* part : vector ? std::vector<const char*>{".x", ".y", ".z"} : std::vector<const char*>{""})
            line += " " + printable(labels[k]) + part;
    }
    return line + "\n";
}

void probe(app::App& app, const Options& o)
{
    const std::vector<Vec3d> points = wanted_points(o);
    const GridFile file = app.read(o.input);
    std::vector<GridBasePtr> grids;
    for (const std::string& name : o.grids) grids.push_back(chosen_grid(file, name));
    if (app.dry_run()) return;
    const auto reading = app.phase("probe");
    std::string table = heading(grids, o.grids);
    size_t outside = 0;
    for (const Vec3d& at : points) {
        nlohmann::json described = {{"at", {at[0], at[1], at[2]}}};
        std::string line = text_of(at[0]) + " " + text_of(at[1]) + " " + text_of(at[2]);
        for (size_t k = 0; k < grids.size(); ++k) {
            const ProbedValue value = value_at(*grids[k], at);
            outside += !value.inside;
            for (const double x : value.components) line += " " + text_of(x);
            described["values"].push_back(
                {{"grid", o.grids[k]}, {"value", value.components}, {"inside", value.inside}});
        }
        table += line + "\n";
        app.report()["points"].push_back(described);
    }
    if (outside > 0)
        app.say(std::to_string(outside) + " values lie outside the active voxels: they are the grid's background");
    app.print(table);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("vdbprobe", "Prints the values of grids at points of the world.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { probe(app, o); });
}
