#include "vdbcloud/scatter/emission_cost.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/active_box.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double alone = 0.05;  // share of the voxels up to which rays follow all light

}  // namespace

double share_by_rays(double emitting, double voxels)
{
    return emitting > 0 ? std::clamp(2 - emitting / (alone * voxels), 0.0, 1.0) : 0.0;
}

bool allows_rays(const ScatterOptions& options)
{
    const auto& periodic = options.periodic;
    const bool walls = !options.solids.empty() && options.closure.iterations > 0;  // sweeps know them
    return options.emission_by_rays && !options.limiter && !options.ground_albedo && !walls && !periodic[0] &&
           !periodic[1] && !periodic[2];
}

bool box_allows_rays(const Blocks& blocks)
{
    const ActiveBox box(blocks);
    double cells = 0;
    for (int face = 0; face < 6; ++face) cells += double(box.cells(face));
    return cells <= std::max(double(1 << 20), 16.0 * double(blocks.active_count()));
}

double emission_steps(const FloatGrid& density, const Vec3SGrid& emission, const ScatterOptions& options)
{
    if (!allows_rays(options)) return 0;
    double emitting = 0;
    const auto inside = density.getConstAccessor();
    for (auto v = emission.cbeginValueOn(); v; ++v)
        if (std::max({(*v)[0], (*v)[1], (*v)[2]}) > 0 && inside.getValue(v.getCoord()) > 0)
            emitting += double(v.getVoxelCount());
    const double voxels = double(density.activeVoxelCount());
    if (share_by_rays(emitting, voxels) == 0) return 0;
    return voxels * std::log2(1 + emitting);
}

}  // namespace vdbcloud
