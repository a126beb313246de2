#include "vdbcloud/scatter/sky_inflow.h"

namespace vdbcloud {

std::array<double, 6> sky_on_faces(const VoxelIndex& index, const Sky& sky, int channel)
{
    std::array<double, 6> radiance;
    for (int face = 0; face < 6; ++face)
        radiance[size_t(face)] = sky.mean_inflow(index.axis(face / 2) * (face % 2 ? 1.0 : -1.0))[channel];
    return radiance;
}

std::vector<float> sky_along(const VoxelIndex& index, const Sky& sky, int channel, const std::vector<Vec3d>& travel)
{
    std::vector<float> radiance;
    for (const Vec3d& s : travel)
        radiance.push_back(
            float(sky.radiance(-(s[0] * index.axis(0) + s[1] * index.axis(1) + s[2] * index.axis(2)))[channel]));
    return radiance;
}

}  // namespace vdbcloud
