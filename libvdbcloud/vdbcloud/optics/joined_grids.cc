#include "vdbcloud/optics/joined_grids.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/lattice.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Prune.h>

#include <tbb/parallel_for.h>

#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

float scaled(float value, double by) { return float(double(value) * by); }
Vec3f scaled(const Vec3f& value, double by)
{
    return {scaled(value[0], by), scaled(value[1], by), scaled(value[2], by)};
}

double total(float value) { return value; }
double total(const Vec3f& value) { return double(value[0]) + double(value[1]) + double(value[2]); }

float sample(const BrickMap& map, const Vec3d& at, float) { return float(map.sample(at)); }
Vec3f sample(const BrickMap& map, const Vec3d& at, const Vec3f&) { return Vec3f(map.sample3(at)); }

/// Sum of the active values [value x voxel].
template<typename GridT>
double sum_of(const GridT& grid)
{
    double sum = 0;
    for_each_active_tile(grid, [&](const auto& tile) { sum += total(*tile) * double(tile.getVoxelCount()); });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto v = leaf->cbeginValueOn(); v; ++v) sum += total(*v);
    return sum;
}

/// An empty grid with this transform.
template<typename GridT>
typename GridT::Ptr empty_grid(const Transform& transform)
{
    auto grid = GridT::create(typename GridT::ValueType(0.0f));
    grid->setTransform(transform.copy());
    return grid;
}

/// Active values, moved by whole voxels and scaled; leaves stay leaves where the move keeps them.
template<typename GridT>
typename GridT::Ptr moved(const GridT& grid, const Coord& by, double scale, const Transform& to)
{
    auto out = empty_grid<GridT>(to);
    for_each_active_tile(grid, [&](const auto& tile) {
        CoordBBox box;
        tile.getBoundingBox(box);
        box.translate(by);
        out->tree().fill(box, scaled(*tile, scale), true);
    });
    auto set = out->getAccessor();
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto v = leaf->cbeginValueOn(); v; ++v) set.setValueOn(v.getCoord() + by, scaled(*v, scale));
    return out;
}

/// Throws unless steps of the target lattice, in the summand's index space, are at most a voxel along each axis.
void require_finer(const Affine& from_target, const std::string& name)
{
    for (const Vec3d& row : from_target.a)
        for (int a = 0; a < 3; ++a)
            if (std::abs(row[a]) > 1 + 1e-6)
                throw UsageError(name +
                                 ": its voxels are shorter along one axis than those of the finest input, so neither "
                                 "lattice holds both: expected inputs of which one is finer along all axes. render "
                                 "takes any lattices and lights them together");
}

constexpr double most_samples = 1 << 28, farthest = 1 << 30;

/// Throws unless the corners of the summand's box have indices on the target lattice.
void require_near(const CoordBBox& box, const Affine& to_target, const std::string& name)
{
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d p;
        for (int a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? box.max()[a] + 8.0 : box.min()[a] - 8.0;
        p = to_target.point(p);
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(p[a]) < farthest))
                throw UsageError(name + ": lies more than 2^30 voxels of the finest input from its voxel 0: expected "
                                        "inputs that are nearer or of like voxels. render takes any lattices and "
                                        "lights them together");
    }
}

/// Throws if so many bricks of the summand hold too many voxels of the target.
void require_few_samples(size_t bricks, const Affine& to_target, const std::string& name)
{
    double samples = double(bricks);
    for (const Vec3d& row : to_target.a) samples *= 8 * (std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2])) + 2;
    if (samples > most_samples) {
        std::ostringstream text;
        text.precision(3);
        text << name << ": its voxels hold about " << samples / double(bricks) / 512
             << " voxels of the finest input each, " << samples
             << " altogether: expected at most 2^28. render takes any lattices and lights them together";
        throw UsageError(text.str());
    }
}

/// Voxels of the target lattice whose centres lie in one brick of the interpolant, with their values.
template<typename Value>
struct Sampled {
    std::vector<std::pair<Coord, Value>> voxels;
};

template<typename GridT>
typename GridT::Ptr resampled(const GridT& grid, const Affine& to_target, const Affine& from_target, double scale,
                              const Transform& to, const std::string& name)
{
    using Value = typename GridT::ValueType;
    const BrickMap map(grid);
    const std::vector<Vec3i>& bricks = map.bricks();
    require_few_samples(bricks.size(), to_target, name);
    std::vector<Sampled<Value>> found(bricks.size());
    tbb::parallel_for(size_t(0), bricks.size(), [&](size_t n) {
        const Vec3i& b = bricks[n];
        Vec3d low(1e300), high(-1e300);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d p =
                to_target.point(8.0 * Vec3d(b[0] + (corner & 1), b[1] + (corner >> 1 & 1), b[2] + (corner >> 2)));
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        }
        for (const Coord& ijk : CoordBBox(Coord::floor(low), Coord::ceil(high))) {
            const Vec3d p = from_target.point(ijk.asVec3d());
            const Coord cell = Coord::floor(p);
            if ((cell[0] >> 3) != b[0] || (cell[1] >> 3) != b[1] || (cell[2] >> 3) != b[2]) continue;
            const Value value = scaled(sample(map, p, Value(0.0f)), scale);
            if (total(value) != 0) found[n].voxels.emplace_back(ijk, value);
        }
    });
    auto out = empty_grid<GridT>(to);
    auto set = out->getAccessor();
    for (const auto& of_brick : found)
        for (const auto& [ijk, value] : of_brick.voxels) set.setValueOn(ijk, value);
    openvdb::tools::prune(out->tree());
    return out;
}

double voxel_volume(const Transform& transform) { return std::abs(transform.baseMap()->determinant()); }

/// One summand on the lattice of `to`. `ratio`: its integral over space before, over the integral after.
template<typename GridT>
typename GridT::Ptr on_lattice(const Summand<GridT>& summand, const Transform& to, double& ratio)
{
    const GridT& grid = *summand.grid;
    ratio = 1;
    const CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) return empty_grid<GridT>(to);
    const Affine to_target = index_map(grid.transform(), to);
    require_near(box, to_target, summand.name);
    const auto shift = lattice_shift(to_target, box.min().asVec3d(), box.max().asVec3d());
    if (shift && is_whole(*shift)) return moved(grid, Coord::round(*shift), summand.scale, to);
    const Affine from_target = index_map(to, grid.transform());
    require_finer(from_target, summand.name);
    auto out = resampled(grid, to_target, from_target, summand.scale, to, summand.name);
    const double before = summand.scale * sum_of(grid) * voxel_volume(grid.transform()),
                 after = sum_of(*out) * voxel_volume(to);
    if (after > 0) ratio = before / after;
    return out;
}

template<typename GridT>
void multiply(GridT& grid, double by)
{
    for_each_active_tile(grid, [&](const auto& tile) { tile.setValue(scaled(*tile, by)); });
    for (auto leaf = grid.tree().beginLeaf(); leaf; ++leaf)
        for (auto v = leaf->beginValueOn(); v; ++v) v.setValue(scaled(*v, by));
}

}  // namespace

template<typename GridT>
size_t finest(const std::vector<Summand<GridT>>& summands)
{
    size_t best = 0;
    for (size_t n = 1; n < summands.size(); ++n)
        if (voxel_volume(summands[n].grid->transform()) < (1 - 1e-6) * voxel_volume(summands[best].grid->transform()))
            best = n;
    return best;
}

template<typename GridT>
std::shared_ptr<GridT> sum_on_lattice(const std::vector<Summand<GridT>>& summands, const Transform& to,
                                      std::vector<double>& kept)
{
    const bool given = !kept.empty();
    auto sum = empty_grid<GridT>(to);
    for (size_t n = 0; n < summands.size(); ++n) {
        double ratio = 1;
        const auto one = on_lattice(summands[n], to, ratio);
        if (!given) kept.push_back(ratio);
        if (kept[n] != 1) multiply(*one, kept[n]);
        openvdb::tools::compSum(*sum, *one);
    }
    return sum;
}

template size_t finest(const std::vector<Summand<FloatGrid>>&);
template size_t finest(const std::vector<Summand<Vec3SGrid>>&);
template FloatGridPtr sum_on_lattice(const std::vector<Summand<FloatGrid>>&, const Transform&, std::vector<double>&);
template Vec3SGridPtr sum_on_lattice(const std::vector<Summand<Vec3SGrid>>&, const Transform&, std::vector<double>&);

}  // namespace vdbcloud
