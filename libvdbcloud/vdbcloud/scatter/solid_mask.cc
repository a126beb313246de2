#include "vdbcloud/scatter/solid_mask.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <tbb/parallel_for.h>

namespace vdbcloud {

FloatGridPtr without_solids(const FloatGrid& density, const SolidRays& solids, const std::array<bool, 3>& periodic)
{
    if (periodic != std::array<bool, 3>{})
        throw InputError("solids beside a medium that repeats: expected one that ends on all sides, or no solids");
    auto open = density.deepCopy();
    open->tree().voxelizeActiveTiles();
    std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
    open->tree().getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t b) {
        for (auto v = leaves[b]->beginValueOn(); v; ++v)
            if (solids.inside(open->indexToWorld(v.getCoord()))) v.setValueOff();
    });
    return open;
}

}  // namespace vdbcloud
