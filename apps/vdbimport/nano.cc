// NanoVDB files.
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/nanovdb_file.h"
#include "vdbcloud/grid/registry.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// Puts the density first: the grid of its name or aliases, else the first fog volume, else the first of unknown class.
void lead_with_density(std::vector<GridBasePtr>& grids)
{
    const auto score = [](const GridBasePtr& grid) {
        if (!grid->isType<FloatGrid>() || grid->getGridClass() == openvdb::GRID_LEVEL_SET) return 3;
        if (schema::has_role(grid->getName(), schema::Role::Density)) return 0;
        return grid->getGridClass() == openvdb::GRID_FOG_VOLUME ? 1 : 2;
    };
    std::stable_sort(grids.begin(), grids.end(),
                     [&](const GridBasePtr& a, const GridBasePtr& b) { return score(a) < score(b); });
}

}  // namespace

void import_nanovdb(app::App& app, const Options& o)
{
    NanoGrids read = read_nanovdb(o.input);
    for (const std::string& line : read.said) app.say(line);
    if (read.grids.empty()) throw InputError(printable(o.input) + ": no grid of floats or of vectors of three");
    lead_with_density(read.grids);
    double bytes = 0, voxels = 0;
    std::string names;
    for (const GridBasePtr& grid : read.grids) {
        bytes += app::value_bytes(*grid);
        voxels += double(grid->activeVoxelCount());
        names += (names.empty() ? "" : ", ") + grid->getName();
    }
    app::Plan plan;
    plan.way_out = "a smaller file";
    plan.work.add("table_cell", voxels);
    plan.work.add("write_byte", bytes);
    if (ended(app, plan, std::to_string(read.grids.size()) + " grids")) return;
    const UpAxis up = o.up.value_or(UpAxis::Y);
    app.say("grids " + names + "; up axis " + (up == UpAxis::Z ? "z" : "y") + (o.up ? "" : ", assumed (--up)"));
    write_import(app, o, o.output, read.grids, up, o.meters_per_unit, false);
}

}  // namespace vdbcloud
