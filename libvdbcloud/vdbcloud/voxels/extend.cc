#include "vdbcloud/voxels/extend.h"

#include "vdbcloud/core/vdb.h"

#include <openvdb/tools/Morphology.h>

#include <tbb/parallel_for.h>

namespace vdbcloud {

namespace {

openvdb::Vec3d wide(const openvdb::Vec3f& v) { return openvdb::Vec3d(v); }
double wide(float v) { return v; }

/// The grid's voxels and their fringe, with the background everywhere.
template<typename Grid>
typename Grid::TreeType::Ptr fringe_tree(const Grid& grid)
{
    openvdb::MaskTree mask(grid.tree(), false, true, openvdb::TopologyCopy());
    mask.voxelizeActiveTiles();
    openvdb::tools::dilateActiveValues(mask, 1, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::IGNORE_TILES);
    return std::make_shared<typename Grid::TreeType>(mask, grid.background(), grid.background(),
                                                     openvdb::TopologyCopy());
}

template<typename Grid>
typename Grid::Ptr fringed(const Grid& grid)
{
    using Tree = typename Grid::TreeType;
    using Value = typename Grid::ValueType;
    auto tree = fringe_tree(grid);
    std::vector<typename Tree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t n) {
        openvdb::tree::ValueAccessor<const Tree> from(grid.tree());
        const auto* own = grid.tree().probeConstLeaf(leaves[n]->origin());  // null: a tile, or fringe alone
        for (auto v = leaves[n]->beginValueOn(); v; ++v) {
            if (own && own->isValueOn(v.pos())) {
                v.setValue(own->getValue(v.pos()));
                continue;
            }
            const openvdb::Coord ijk = v.getCoord();
            Value value;
            if (from.probeValue(ijk, value)) {
                v.setValue(value);
                continue;
            }
            auto sum = wide(Value(0.0f));
            int count = 0;
            for (int d = 0; d < 27; ++d)
                if (from.probeValue(ijk.offsetBy(d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1), value)) {
                    sum += wide(value);
                    ++count;
                }
            v.setValue(Value(sum / count));
        }
    });
    auto out = Grid::create(tree);
    out->setTransform(grid.transform().copy());
    out->setName(grid.getName());
    return out;
}

template<typename Grid>
typename Grid::Ptr fringed(const Grid& grid, const Period& period)
{
    if (!period.any()) return fringed(grid);
    auto out = wrapped(*fringed(*wrapped(grid, period)), period);
    out->tree().voxelizeActiveTiles();  // clipping made tiles of constant leaves
    return out;
}

}  // namespace

Vec3SGridPtr with_fringe(const Vec3SGrid& grid, const Period& period) { return fringed(grid, period); }
FloatGridPtr with_fringe(const FloatGrid& grid, const Period& period) { return fringed(grid, period); }

FloatGridPtr voxels_with_fringe(const FloatGrid& grid, const Period& period)
{
    return period.any() ? fringed(grid, period) : openvdb::FloatGrid::create(fringe_tree(grid));
}

}  // namespace vdbcloud
