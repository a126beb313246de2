#include "vdbcloud/optics/thermal_emission.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/joined_grids.h"
#include "vdbcloud/scene/blackbody.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbcloud {

namespace {

using openvdb::Coord;
using openvdb::math::Transform;

constexpr double most_filled = 0x1p28;     // voxels of tiles that are not of one emission
constexpr double largest_emission = 1e30;  // sums of many stay finite as floats

/// Values of a scalar grid at voxels of another lattice. One object per thread.
class ScalarAt {
public:
    ScalarAt(const FloatGrid& grid, const Transform& voxels)
        : at_(grid.getConstAccessor()), own_(grid.transform()), voxels_(voxels), same_(own_ == voxels)
    {
    }
    double operator()(const Coord& voxel) const
    {
        if (same_) return double(at_.getValue(voxel));
        return double(openvdb::tools::BoxSampler::sample(at_, own_.worldToIndex(voxels_.indexToWorld(voxel))));
    }

private:
    FloatGrid::ConstAccessor at_;
    const Transform &own_, &voxels_;
    bool same_;
};

/// What a medium emits at voxels of its density. One object per thread.
class EmissionAt {
public:
    EmissionAt(const FloatGrid& density, const Medium& medium, const Vec3SGrid* tint, const Fire& fire,
               const BlackbodyTable& blackbody)
        : medium_(medium), fire_(fire), blackbody_(blackbody), density_(density, density.transform()),
          heat_(*fire.heat(), density.transform())
    {
        const Vec3d& sigma_t = medium.sigma_t_per_density;
        flame_absorption_ =
            fire.flame_absorption < 0 ? (sigma_t[0] + sigma_t[1] + sigma_t[2]) / 3 : fire.flame_absorption;
        if (fire.flame) flame_.emplace(*fire.flame, density.transform());
        if (tint) tint_.emplace(*tint, density.transform());
    }

    Vec3f operator()(const Coord& voxel) const
    {
        const double density = std::max(density_(voxel), 0.0), flame = flame_ ? std::max((*flame_)(voxel), 0.0) : 0;
        const double kelvin = density > 0 || flame > 0 ? fire_.kelvin(heat_(voxel)) : 0;
        if (!(kelvin >= coldest_light)) return Vec3f(0.0f);
        const Vec3d radiance = fire_.intensity * blackbody_(kelvin);
        const Vec3d tint = tint_ ? Vec3d((*tint_)(voxel.asVec3i())) : Vec3d(1.0);
        Vec3f j;
        for (int c = 0; c < 3; ++c) {
            const double share = 1 - std::clamp(medium_.albedo[c] * tint[c], 0.0, 1.0);
            const double absorption = medium_.sigma_t_per_density[c] * density * share + flame_absorption_ * flame;
            j[c] = float(std::min(absorption * radiance[c], largest_emission));
        }
        return j;
    }

private:
    const Medium& medium_;
    const Fire& fire_;
    const BlackbodyTable& blackbody_;
    double flame_absorption_;
    ScalarAt density_, heat_;
    std::optional<ScalarAt> flame_;
    std::optional<VoxelMean> tint_;
};

/// True if a grid, which may be null, has one value throughout a tile of the lattice `voxels`, at this depth of a tree.
template<typename GridT>
bool is_constant(const GridT* grid, const Transform& voxels, const Coord& first, int depth)
{
    if (!grid) return true;
    return grid->transform() == voxels && grid->getConstAccessor().getValueDepth(first) <= depth;
}

/// Active where there may be emission.
Vec3SGridPtr topology_of(const FloatGrid& density, const Fire& fire)
{
    const Transform& voxels = density.transform();
    auto out = Vec3SGrid::create(Vec3f(0.0f));
    out->setName(schema::emission);
    out->setTransform(voxels.copy());
    out->setTree(std::make_shared<openvdb::Vec3STree>(density.tree(), Vec3f(0.0f), openvdb::TopologyCopy()));
    if (fire.flame && fire.flame->transform() == voxels) {
        out->topologyUnion(*fire.flame);
    } else if (fire.flame) {
        const auto flame = FloatGrid::create(0.0f);
        flame->setTransform(voxels.copy());
        openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(*fire.flame, *flame);
        out->topologyUnion(*flame);
    }
    const FloatGrid& heat = *fire.heat();
    if (heat.transform() == voxels && !(fire.kelvin(double(heat.background())) >= coldest_light))
        out->topologyIntersection(heat);
    return out;
}

/// Gives voxels to the tiles that are not of one emission.
void fill_tiles(Vec3SGrid& out, const FloatGrid& density, const Vec3SGrid* tint, const Fire& fire)
{
    std::vector<openvdb::CoordBBox> uneven;
    double voxels = 0;
    for_each_active_tile(out, [&](const auto& tile) {
        const int depth = int(tile.getDepth());
        const auto constant = [&](const auto* grid) {
            return is_constant(grid, out.transform(), tile.getCoord(), depth);
        };
        if (constant(&density) && constant(fire.heat()) && constant(fire.flame.get()) && constant(tint)) return;
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        voxels += double(box.volume());
        uneven.push_back(box);
    });
    if (voxels > most_filled)
        throw InputError("grid '" + printable(fire.heat()->getName()) +
                         "': its temperatures lie across tiles of more than 2^28 voxels of density: expected a density "
                         "of voxels where it is hot");
    for (const openvdb::CoordBBox& box : uneven) {
        const auto edge = int(openvdb::Vec3STree::LeafNodeType::DIM);
        for (int x = box.min().x(); x <= box.max().x(); x += edge)
            for (int y = box.min().y(); y <= box.max().y(); y += edge)
                for (int z = box.min().z(); z <= box.max().z(); z += edge) out.tree().touchLeaf(Coord(x, y, z));
    }
}

template<typename T>
void require_affine(const T& grid)
{
    if (!grid.transform().isLinear())
        throw InputError("grid '" + printable(grid.getName()) +
                         "' has a frustum (non-linear) transform: expected an affine one");
}

}  // namespace

double hottest(const Fire& fire)
{
    const FloatGrid* heat = fire.heat();
    double most = 0;
    if (!heat) return most;
    for (auto v = heat->cbeginValueOn(); v; ++v) most = std::max(most, fire.kelvin(double(*v)));
    return most;
}

Vec3SGridPtr thermal_emission(const FloatGrid& density, const Medium& medium, const Vec3SGrid* tint, const Fire& fire)
{
    const double most = hottest(fire);
    if (!(most >= coldest_light) || !(fire.intensity > 0)) return nullptr;
    require_affine(*fire.heat());
    if (fire.flame) require_affine(*fire.flame);
    const BlackbodyTable blackbody(most);
    const Vec3SGridPtr out = topology_of(density, fire);
    fill_tiles(*out, density, tint, fire);
    const EmissionAt of_tile(density, medium, tint, fire, blackbody);
    for_each_active_tile(*out, [&](const auto& tile) {
        const Vec3f j = of_tile(tile.getCoord());
        tile.setValue(j);
        if (j == Vec3f(0.0f)) tile.setActiveState(false);
    });
    std::vector<openvdb::Vec3STree::LeafNodeType*> leaves;
    out->tree().getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t n) {
        const EmissionAt at(density, medium, tint, fire, blackbody);
        for (auto v = leaves[n]->beginValueOn(); v; ++v) {
            const Vec3f j = at(v.getCoord());
            v.setValue(j);
            if (j == Vec3f(0.0f)) v.setValueOff();
        }
    });
    openvdb::tools::pruneInactive(out->tree());
    return out->activeVoxelCount() > 0 ? out : nullptr;
}

Vec3SGridPtr sum_of_emission(const Vec3SGridPtr& a, const Vec3SGridPtr& b)
{
    if (!a || !b) return a ? a : b;
    const std::vector<Summand<Vec3SGrid>> parts{{a, 1.0, a->getName()}, {b, 1.0, b->getName()}};
    std::vector<double> kept;
    auto sum = sum_on_lattice(parts, parts[finest(parts)].grid->transform(), kept);
    sum->setName(a->getName());
    return sum;
}

}  // namespace vdbcloud
