// Finds the density grid of a file and checks its values.
#include "vdbcloud/grid/density.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace vdbcloud {

namespace {

std::string called(const GridFile& file, const GridBase& grid)
{
    return printable(file.path, 4096) + ": grid '" + printable(grid.getName()) + "'";
}

bool is_real(const GridBase& grid) { return grid.isType<FloatGrid>() || grid.isType<openvdb::DoubleGrid>(); }

/// The density if no alias matches. Among float and double grids whose names no stage uses: the only grid of class fog,
/// else the only grid of unknown class. Throws InputError if there are several.
GridBasePtr only_fog(const GridFile& file)
{
    for (const auto wanted : {openvdb::GRID_FOG_VOLUME, openvdb::GRID_UNKNOWN}) {
        std::vector<GridBasePtr> found;
        for (const auto& grid : file.grids)
            if (grid && is_real(*grid) && grid->getGridClass() == wanted && !schema::kind_of(grid->getName()))
                found.push_back(grid);
        if (found.size() == 1) return found.front();
        if (found.size() > 1)
            throw InputError(printable(file.path, 4096) +
                             ": several grids may be the density: expected a choice among " + grid_list(file));
    }
    return nullptr;
}

/// The reason why a grid is not usable as density, as the end of a sentence; empty for a usable grid.
std::string objection(const GridBase& grid)
{
    if (grid.type().find("ptdataidx") != std::string::npos)
        return "holds points: expected a fog volume (vdb_tool -read in.vdb -points2ls -ls2fog -write fog.vdb makes "
               "one)";
    if (!is_real(grid)) return "holds values of type " + printable(grid.valueType()) + ": expected float or double";
    if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
        return "is a level set: expected a fog volume (vdb_tool -read in.vdb -ls2fog -write fog.vdb makes one)";
    if (!grid.transform().isLinear()) return "has a frustum (non-linear) transform: expected an affine one";
    return {};
}

GridBasePtr pick(const GridFile& file, const std::string& asked)
{
    GridBasePtr grid = !asked.empty() ? chosen_grid(file, asked) : aliased_grid(file, schema::density);
    if (!grid) grid = only_fog(file);
    if (!grid && file.grids.size() == 1) grid = file.grids.front();  // objection() then gives the reason
    if (!grid) throw InputError(printable(file.path, 4096) + ": no density among its grids: it has " + grid_list(file));
    if (const std::string why = objection(*grid); !why.empty()) throw InputError(called(file, *grid) + " " + why);
    return grid;
}

/// What an earlier stage was told to take for the density; empty if nothing, or if there is no such grid.
std::string earlier_choice(const GridFile& file, const Warn& to)
{
    std::string choice = file.metadata ? get_text(*file.metadata, schema::density_choice, "") : "";
    if (choice.empty()) return choice;
    const auto labels = grid_labels(file);
    const auto named = [&](const GridBasePtr& grid) { return grid && grid->getName() == choice; };
    if (std::count(labels.begin(), labels.end(), choice) == 1 ||
        std::count_if(file.grids.begin(), file.grids.end(), named) == 1)
        return choice;
    warn(to, printable(file.path, 4096) + ": an earlier stage took grid '" + printable(choice) +
                 "' for the density, and it is not there: expected it among " + grid_list(file) +
                 "; chosen by name instead");
    return {};
}

/// Values that become others before anyone uses them.
struct Repairs {
    uint64_t negative = 0;    ///< become 0
    uint64_t not_finite = 0;  ///< of inactive voxels and tiles: become the background
};

/// Counts values to repair of all voxels and tiles (active and inactive) and of the background, because trilinear
/// interpolation uses all of them. Throws InputError at the first active value that is not finite.
Repairs repairs_of(const FloatGrid& grid, const std::string& what)
{
    const auto refuse_value = [&](float value, const auto& where) {
        std::ostringstream text;
        text << what << ": value " << value << " " << where << ": expected finite";
        throw InputError(text.str());
    };
    const auto at = [](const openvdb::Coord& ijk) {
        std::ostringstream text;
        text << "at voxel " << ijk;
        return text.str();
    };
    if (!std::isfinite(grid.background())) refuse_value(grid.background(), "as background");
    Repairs count;
    count.negative = grid.background() < 0;
    for_each_tile(grid, [&](const auto& tile) {
        if (!std::isfinite(*tile) && tile.isValueOn()) refuse_value(*tile, at(tile.getCoord()));
        count.not_finite += !std::isfinite(*tile);
        count.negative += std::isfinite(*tile) && *tile < 0;
    });
    constexpr int size = int(FloatGrid::TreeType::LeafNodeType::SIZE);
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const float* values = leaf->buffer().data();
        constexpr float most = std::numeric_limits<float>::max();
        int below = 0, finite = 0;
        for (int k = 0; k < size; ++k) {
            below += values[k] < 0 && values[k] >= -most;
            finite += std::abs(values[k]) <= most;
        }
        for (int k = 0; finite != size && k < size; ++k)
            if (!std::isfinite(values[k]) && leaf->isValueOn(openvdb::Index(k)))
                refuse_value(values[k], at(leaf->offsetToGlobalCoord(openvdb::Index(k))));
        count.negative += uint64_t(below);
        count.not_finite += uint64_t(size - finite);
    }
    return count;
}

/// Values below `least`, and those that are not finite.
void repair(FloatGrid& grid, float least)
{
    if (grid.background() < least) grid.tree().root().setBackground(least, /*updateChildNodes=*/true);
    const float background = grid.background();
    const auto repaired = [=](float x) { return std::isfinite(x) ? std::max(x, least) : background; };
    for_each_tile(grid, [&](const auto& tile) {
        if (const float value = repaired(*tile); value != *tile) tile.setValue(value);
    });
    for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf) {
        float* values = leaf->buffer().data();
        for (int k = 0; k < int(FloatGrid::TreeType::LeafNodeType::SIZE); ++k) values[k] = repaired(values[k]);
    }
}

std::string counted(uint64_t n, const std::string& one) { return std::to_string(n) + " " + one + (n == 1 ? "" : "s"); }

void tell_not_finite(const Repairs& count, const std::string& what, const Warn& to)
{
    if (count.not_finite > 0)
        warn(to, what + ": " + counted(count.not_finite, "value") +
                     " of inactive voxels not finite: taken as the background");
}

/// A grid of floats or doubles as floats.
FloatGridPtr as_floats(const GridBasePtr& base)
{
    if (auto grid = openvdb::gridPtrCast<FloatGrid>(base)) return grid;
    return std::make_shared<FloatGrid>(static_cast<const openvdb::DoubleGrid&>(*base));
}

}  // namespace

FloatGridPtr density_of(GridFile& file, const std::string& asked, const Warn& to)
{
    const std::string choice = asked.empty() ? earlier_choice(file, to) : asked;
    const GridBasePtr base = pick(file, choice);
    if (!asked.empty() && file.metadata) set_text(*file.metadata, schema::density_choice, asked);
    FloatGridPtr grid = as_floats(base);
    const std::string what = called(file, *base);
    const Repairs count = repairs_of(*grid, what);
    if (count.negative + count.not_finite > 0) {
        if (grid == base) grid = grid->deepCopy();
        repair(*grid, 0.0f);
    }
    if (count.negative > 0) warn(to, what + ": " + counted(count.negative, "negative value") + " taken as 0");
    tell_not_finite(count, what, to);
    if (grid != base) std::replace(file.grids.begin(), file.grids.end(), base, GridBasePtr(grid));
    return grid;
}

FloatGridPtr scalar_of(const GridFile& file, const std::string& role, const Warn& to)
{
    const GridBasePtr base = aliased_grid(file, role);
    if (!base || base->empty()) return nullptr;
    const std::string what = called(file, *base);
    if (const std::string why = objection(*base); !why.empty()) {
        warn(to, what + " " + why + "; the grid is ignored");
        return nullptr;
    }
    FloatGridPtr grid = as_floats(base);
    const Repairs count = repairs_of(*grid, what);
    if (count.not_finite > 0) {
        if (grid == base) grid = grid->deepCopy();
        repair(*grid, -std::numeric_limits<float>::max());
    }
    tell_not_finite(count, what, to);
    return grid;
}

}  // namespace vdbcloud
