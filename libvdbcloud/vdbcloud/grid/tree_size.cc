#include "vdbcloud/grid/tree_size.h"

#include "vdbcloud/core/vdb.h"

namespace vdbcloud {

double TreeSize::table_memory(double value_bytes) const
{
    const double entry = value_bytes <= 8 ? 8 : 16, masks = 2.0 / 8;
    return (entry + masks) * (4096 * nodes + 32768 * tops);
}

TreeSize tree_size(const GridBase& grid)
{
    const auto count = grid.constBaseTree().nodeCount();  // from leaves to the root
    const auto at = [&](size_t level) { return level < count.size() ? double(count[level]) : 0.0; };
    return {at(0), at(1), at(2)};
}

}  // namespace vdbcloud
