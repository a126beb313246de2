#include "vdbcloud/grid/extend.h"

#include "vdbcloud/core/vdb.h"

#include <openvdb/tools/Morphology.h>

#include <tbb/parallel_for.h>

namespace vdbcloud {

Vec3SGridPtr extended(const Vec3SGrid& grid)
{
    openvdb::MaskTree mask(grid.tree(), false, true, openvdb::TopologyCopy());
    mask.voxelizeActiveTiles();
    openvdb::tools::dilateActiveValues(mask, 1, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::IGNORE_TILES);
    auto tree = std::make_shared<openvdb::Vec3STree>(mask, grid.background(), grid.background(), openvdb::TopologyCopy());
    std::vector<openvdb::Vec3STree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t n) {
        openvdb::tree::ValueAccessor<const openvdb::Vec3STree> from(grid.tree());
        for (auto v = leaves[n]->beginValueOn(); v; ++v) {
            const openvdb::Coord ijk = v.getCoord();
            openvdb::Vec3f value;
            if (from.probeValue(ijk, value)) {
                v.setValue(value);
                continue;
            }
            openvdb::Vec3d sum(0);
            int count = 0;
            for (int d = 0; d < 27; ++d)
                if (from.probeValue(ijk.offsetBy(d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1), value)) {
                    sum += openvdb::Vec3d(value);
                    ++count;
                }
            v.setValue(openvdb::Vec3f(sum / count));
        }
    });
    auto out = openvdb::Vec3SGrid::create(tree);
    out->setTransform(grid.transform().copy());
    out->setName(grid.getName());
    return out;
}

}  // namespace vdbcloud
