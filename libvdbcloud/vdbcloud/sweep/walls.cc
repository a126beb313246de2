#include "vdbcloud/sweep/walls.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <numeric>

namespace vdbcloud {

namespace {

/// Where each block's begin in a list that is sorted by block, and the end.
template<typename BlockOf>
std::vector<uint32_t> begins(size_t blocks, size_t count, const BlockOf& block_of)
{
    std::vector<uint32_t> begin(blocks + 1, 0);
    for (size_t n = 0; n < count; ++n) ++begin[block_of(n) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    return begin;
}

}  // namespace

void SweepWalls::sort(const Blocks& blocks)
{
    voxels_of = begins(blocks.count(), voxels.size(), [&](size_t n) { return voxels[n].slot / Blocks::size; });
    before.clear();
    for (uint32_t e = 0; e < elements.size(); ++e)
        if (elements[e].outside != nowhere) before.push_back(e);
    std::stable_sort(before.begin(), before.end(), [&](uint32_t p, uint32_t q) {
        return elements[p].outside / Blocks::size < elements[q].outside / Blocks::size;
    });
    elements_of =
        begins(blocks.count(), before.size(), [&](size_t n) { return elements[before[n]].outside / Blocks::size; });
}

float WallLight::along(const SweepWalls::Voxel& voxel, const Vec3d& s) const
{
    double sum = 0, weights = 0, all = 0;
    for (uint32_t n = voxel.first; n < voxel.first + voxel.count; ++n) {
        const uint32_t e = walls->seen[n];
        const double weight = std::max(0.0, s.dot(walls->elements[e].normal));
        sum += weight * double(radiance[e]);
        weights += weight;
        all += double(radiance[e]);
    }
    return float(weights > 0 ? sum / weights : voxel.count > 0 ? all / voxel.count : 0.0);
}

void WallSums::write()
{
    of_.irradiance.resize(sum_.size(), 0.0f);
    for (size_t e = 0; e < sum_.size(); ++e)
        if (unit_[e] > 0) of_.irradiance[e] = float(sum_[e] * pi / unit_[e]);
}

}  // namespace vdbcloud
