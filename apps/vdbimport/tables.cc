// Tables: a cloud of optical depths, as models and retrievals write them, or a medium of boxes, as benchmarks of
// transport describe them. The first two layouts are those of phase I of the I3RC (Cahalan et al. 2005).
#include "content.h"
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/table.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/voxels/box_medium.h"
#include "vdbcloud/voxels/cloud_table.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud {

namespace {

UpAxis up_of(const Options& o) { return o.up.value_or(UpAxis::Y); }

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
    const int up = index_of(up_of(o));
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
    const CloudCells cells{o.cell, o.base, index_of(up_of(o))};
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

}  // namespace

void import_table(app::App& app, const Options& o)
{
    if (!(o.cell[0] > 0)) throw UsageError("--cell is missing: a table needs --cell DX,DY,DZ, the size of its cells");
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
    const std::vector<GridBasePtr> grids = imported(app, o, tables);
    const GridBase& density = *grids.front();
    app.say(std::to_string(table.rows) + " rows of " + std::to_string(table.columns) +
            " numbers: " + std::to_string(density.activeVoxelCount()) + " voxels of matter");
    if (density.empty()) app.warnings()(o.input + ": no cell is above 0: the density is empty");
    write_import(app, o, o.output, grids, up_of(o), o.meters_per_unit, true);
}

}  // namespace vdbcloud
