#pragma once
// The loop over the voxels of a medium. Private to scatter/.
#include "vdbcloud/voxels/blocks.h"

#include <tbb/parallel_for.h>

namespace vdbcloud {

/// Calls f(slot) for each active slot. Blocks run in parallel, so f may write to its own slot only.
template<typename F>
void each_active(const Blocks& blocks, const F& f)
{
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            if (blocks.active(slot)) f(slot);
    });
}

}  // namespace vdbcloud
