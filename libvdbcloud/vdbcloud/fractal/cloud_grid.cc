#include "vdbcloud/fractal/cloud_grid.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/voxel_transform.h"
#include "vdbcloud/grid/schema.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace vdbcloud {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

openvdb::Coord coord(const Vec3i& v) { return {v[0], v[1], v[2]}; }

std::unique_ptr<Leaf> leaf_of(const CloudBlocks::Block& block)
{
    auto leaf = std::make_unique<Leaf>(coord(block.origin), 0.0f);
    float* values = leaf->buffer().data();
    for (openvdb::Index n = 0; n < Leaf::SIZE; ++n) {
        values[n] = block.values[n];
        if (values[n] > 0) leaf->setValueOn(n);
    }
    return leaf;
}

}  // namespace

std::shared_ptr<Transform> voxel_centre_transform(const Box& domain, const Vec3i& size)
{
    const Vec3d sides = domain.sides(), step(sides[0] / size[0], sides[1] / size[1], sides[2] / size[2]);
    auto transform = voxel_transform(step);
    transform->postTranslate(domain.low + 0.5 * step);
    return transform;
}

FloatGridPtr cloud_grid(const CloudBlocks& cloud)
{
    std::vector<std::unique_ptr<Leaf>> leaves(cloud.blocks.size());
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t b) {
        if (cloud.blocks[b].values) leaves[b] = leaf_of(cloud.blocks[b]);
    });
    auto grid = FloatGrid::create(0.0f);
    for (size_t b = 0; b < leaves.size(); ++b) {
        if (leaves[b])
            grid->tree().addLeaf(leaves[b].release());
        else
            grid->tree().addTile(1, coord(cloud.blocks[b].origin), 1.0f, true);
    }
    grid->setTransform(voxel_centre_transform(cloud.domain, cloud.size));
    grid->setName(schema::density);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

}  // namespace vdbcloud
