// vdbimport: a cloud from a table of optical depths, as models and retrievals write them, as a density grid; or a
// medium of boxes, as benchmarks of transport describe them.
//
//   vdbimport radar.txt --cell 50,50,45 -o radar.vdb
//   vdbimport depth.txt --thickness thickness.txt --thickness-unit 1000 --cell 30,30,30 --base 200 -o scene.vdb
//   vdbimport duct.txt --boxes --cell 2,2,2 -o duct.vdb
//
// The first two layouts are those of phase I of the I3RC (Cahalan et al. 2005). The grid holds extinction: sigma_t is
// density times 1, unless --extinction says otherwise.
#include "content.h"
#include "medium_options.h"
#include "plan.h"
#include "stage_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/table.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/voxels/box_medium.h"
#include "vdbcloud/voxels/cloud_table.h"

#include <algorithm>
#include <cmath>
#include <functional>

using namespace vdbcloud;

namespace {

enum class Values { OpticalDepth, Extinction };

struct Options {
    std::string input, output, thickness;
    Vec3d cell{0, 0, 0};
    double base = 0, thickness_unit = 1;
    int across = 1;
    bool boxes = false;
    Values values = Values::OpticalDepth;
    UpAxis up = UpAxis::Y;
    app::MediumOptions medium;
};

void declare(app::App& app, Options& o)
{
    app.writes_grids();
    app.add_option(
           "input", o.input,
           "a table of numbers, a row a line, or - for standard input: a vertical section whose rows are layers, "
           "the top one first; with --thickness a map of columns; with --boxes a list of boxes")
        ->required()
        ->type_name("FILE")
        ->reads_files();
    app.add_option("-o,--output", o.output, "the cloud to write: a .vdb, or - for standard output")
        ->required()
        ->type_name("FILE")
        ->writes_file(app::FileKind::Grids);
    app.add_option(
           "--cell", o.cell,
           "DX,DY,DZ: size of a cell along a row (x), across, and vertically [world unit]; tables of the I3RC are in "
           "metres")
        ->required()
        ->check(app::positive);
    const auto boxes = [&o] { return o.boxes; };
    app.add_flag("--boxes", o.boxes,
                 "a row of the table is a box: x0 y0 z0 x1 y1 z1 [world unit], extinction [1/world unit], and emission "
                 "[radiance/world unit] where there is an eighth number. A voxel has the values of the last box that "
                 "holds its centre");
    app.add_choice<Values>(
           "--values", o.values, {{"optical-depth", Values::OpticalDepth}, {"extinction", Values::Extinction}},
           "what a number of the table is: optical depth of a cell from top to base, or of a whole column "
           "with --thickness; or extinction [1/world unit]")
        .not_with(boxes, "--boxes");
    const app::Option thickness =
        app.add_option("--thickness", o.thickness, "a table of the same shape: geometric thickness of each column")
            .not_with(boxes, "--boxes");
    thickness->type_name("FILE")->reads_files();
    app.add_option("--thickness-unit", o.thickness_unit, "world units in a unit of --thickness: 1000 for km and m")
        ->check(app::positive)
        ->needs(thickness);
    app.add_option("--across", o.across, "cells across a section, which are all alike")
        ->check(app::within(1, 4096))
        ->not_with([&o] { return !o.thickness.empty(); }, "--thickness")
        ->not_with(boxes, "--boxes");
    app.add_option("--base", o.base, "height of the cloud's base [world unit]").not_with(boxes, "--boxes");
    app.add_choice<UpAxis>("--up", o.up, app::up_axis_choices(), "axis that points up")->scene("medium");
    app::declare_medium(app, o.medium, app::MediumSource::None);
    app.examples(
        {{"a section of two columns and three layers, rendered",
          "printf '0 1\\n2 4\\n2 2\\n' > section.txt && vdbimport section.txt --cell 50,50,45 --across 4 -o "
          "section.vdb && "
          "render section.vdb --resolution 64 -o section.png"},
         {"a map of two columns of optical depth, 0.2 and 0.3 km thick",
          "printf '5 8\\n' > depth.txt && printf '0.2 0.3\\n' > km.txt && vdbimport depth.txt --thickness km.txt "
          "--thickness-unit 1000 --cell 30,30,30 -o columns.vdb"},
         {"from standard input, with the mean optical depth as JSON",
          "printf '0 1\\n2 4\\n' | vdbimport - --cell 50,50,45 -o depths.vdb --json -"}});
}

/// The table of a section as a grid.
FloatGridPtr section(const Options& o, const CloudCells& cells, const Table& table)
{
    const double per_length = o.values == Values::OpticalDepth ? 1 / o.cell[2] : 1;
    return section_cloud(table.columns, table.rows, o.across, cells, [&](size_t column, size_t layer) {
        return per_length * table.at(table.rows - 1 - layer, column);
    });
}

/// The tables of a run; `thickness` is empty without --thickness.
struct Tables {
    Table values, thickness;
};

/// Throws InputError.
Tables read_tables(const Options& o)
{
    Tables tables{read_table(o.input), {}};
    if (o.thickness.empty()) return tables;
    const Table& table = tables.values;
    const Table& thickness = tables.thickness = read_table(o.thickness);
    if (thickness.rows != table.rows || thickness.columns != table.columns)
        throw InputError(o.thickness + ": " + std::to_string(thickness.rows) + " rows of " +
                         std::to_string(thickness.columns) + " numbers: expected " + std::to_string(table.rows) +
                         " of " + std::to_string(table.columns) + ", as the input has");
    return tables;
}

FloatGridPtr columns(const Options& o, const CloudCells& cells, const Tables& tables)
{
    const Table &table = tables.values, &thickness = tables.thickness;
    const auto thick = [&](size_t x, size_t y) { return o.thickness_unit * thickness.at(y, x); };
    return column_cloud(
        table.columns, table.rows, cells,
        [&](size_t x, size_t y) { return table.at(y, x) * (o.values == Values::OpticalDepth ? 1 : thick(x, y)); },
        thick);
}

/// Mean over the columns of the optical depth from top to base, at extinction 1 a density.
double mean_depth(const FloatGrid& grid, const Options& o, const Table& table)
{
    double sum = 0;
    for (auto v = grid.cbeginValueOn(); v; ++v) sum += double(*v);
    const double count = double(table.columns) * double(o.thickness.empty() ? size_t(o.across) : table.rows);
    return sum * o.cell[2] / count;
}

/// The rows of a table as boxes. Throws InputError for rows of another length.
std::vector<MediumBox> boxes_of(const Options& o, const Table& table)
{
    if (table.columns != 7 && table.columns != 8)
        throw InputError(printable(o.input) + ": rows of " + std::to_string(table.columns) +
                         " numbers: expected x0 y0 z0 x1 y1 z1 extinction, and emission if there is any");
    std::vector<MediumBox> boxes;
    for (size_t row = 0; row < table.rows; ++row) {
        const auto corner = [&](size_t first) {
            return Vec3d(table.at(row, first), table.at(row, first + 1), table.at(row, first + 2));
        };
        boxes.push_back({corner(0), corner(3), table.at(row, 6), table.columns == 8 ? table.at(row, 7) : 0});
    }
    return boxes;
}

/// Size of a cell along x, y, z of the world.
Vec3d axes_of(const Options& o)
{
    const int up = index_of(o.up);
    Vec3d size(o.cell[0]);
    size[3 - up] = o.cell[1];
    size[up] = o.cell[2];
    return size;
}

Content content_of(const Options& o, const Tables& tables)
{
    const Table& table = tables.values;
    if (o.boxes) {
        const std::vector<MediumBox> boxes = boxes_of(o, table);
        check(boxes, axes_of(o));
        return content_of_boxes(boxes, axes_of(o));
    }
    if (o.thickness.empty())
        return content_of_columns(table.columns, size_t(o.across), [&](size_t, size_t) { return double(table.rows); });
    return content_of_columns(table.columns, table.rows, [&](size_t x, size_t y) {
        return table.at(y, x) > 0 ? std::ceil(std::max(o.thickness_unit * tables.thickness.at(y, x), 0.0) / o.cell[2])
                                  : 0;
    });
}

app::Plan plan_of(const Options& o, const Tables& tables)
{
    app::Plan plan;
    const Content content = content_of(o, tables);
    // extinction is one float a voxel, emission three
    const double floats = o.boxes && tables.values.columns == 8 ? 4 : 1;
    plan.way_out = "larger cells (--cell)";
    const TreeSize size{content.blocks[0], content.blocks[1], content.blocks[2]};
    plan.bytes = floats * size.memory(4);
    plan.work.add("table_cell", content.voxels);
    plan.work.add("write_byte", floats * size.values(4));
    return plan;
}

/// The grids of a table: density, and emission if there is any.
std::vector<GridBasePtr> imported(app::App& app, const Options& o, const Tables& tables)
{
    const CloudCells cells{o.cell, o.base, index_of(o.up)};
    const Table& table = tables.values;
    if (o.boxes) {
        const BoxMedium medium = box_medium(boxes_of(o, table), axes_of(o));
        medium.extinction->setName(schema::density);
        if (!medium.emission) return {medium.extinction};
        medium.emission->setName(schema::emission);
        return {medium.extinction, medium.emission};
    }
    const FloatGridPtr grid = o.thickness.empty() ? section(o, cells, table) : columns(o, cells, tables);
    grid->setName(schema::density);
    const double depth = mean_depth(*grid, o, table);
    app.report()["table"]["mean_optical_depth"] = depth;
    app.say("mean optical depth of the columns " + app::brief(depth));
    return {grid};
}

void import(app::App& app, const Options& o)
{
    const Tables tables = read_tables(o);
    const Table& table = tables.values;
    app.report()["table"] = {{"rows", table.rows}, {"columns", table.columns}};
    const app::Plan plan = plan_of(o, tables);
    if (app.dry_run())
        return app::tell(app, plan,
                         "make up to " + app::brief(plan.work.of("table_cell")) + " voxels of " +
                             std::to_string(table.rows) + " rows of " + std::to_string(table.columns) + " numbers");
    app::require_memory(plan);
    Workload cells;
    cells.add("table_cell", plan.work.of("table_cell"));
    app.add_work(cells);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = imported(app, o, tables);
    GridBase& density = *file.grids.front();
    set_vector(density, schema::sigma_t_per_density, Vec3d(1.0));
    set_text(density, schema::sigma_t_origin, "given");
    app::write_given_medium(o.medium, density);
    app.report()["counts"]["voxels"] = density.activeVoxelCount();
    app.say(std::to_string(table.rows) + " rows of " + std::to_string(table.columns) +
            " numbers: " + std::to_string(density.activeVoxelCount()) + " voxels of matter");
    if (density.empty()) app.warnings()(o.input + ": no cell is above 0: the density is empty");
    write_up_axis(*file.metadata, o.up);
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("vdbimport",
                 "A density grid from a table: a cloud of optical depths or extinctions, or a medium of boxes.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { import(app, o); });
}
