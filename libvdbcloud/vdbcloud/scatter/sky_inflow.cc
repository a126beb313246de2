#include "vdbcloud/scatter/sky_inflow.h"

namespace vdbcloud {

std::array<double, 6> sky_on_faces(const VoxelIndex& index, const Sky& sky, int channel)
{
    std::array<double, 6> radiance;
    for (int face = 0; face < 6; ++face)
        radiance[size_t(face)] = sky.mean_inflow(index.axis(face / 2) * (face % 2 ? 1.0 : -1.0))[channel];
    return radiance;
}

namespace {

/// For each direction the mean over the parts that are nearer to it than to any other; where there is none, that of the
/// direction.
std::vector<float> means_about(const std::vector<Vec3d>& towards, const Sky& sky, int channel)
{
    std::vector<double> sum(towards.size(), 0), size(towards.size(), 0);
    for (const SkyPart& part : sky.parts()) {
        size_t nearest = 0;
        for (size_t m = 1; m < towards.size(); ++m)
            if (towards[m].dot(part.direction) > towards[nearest].dot(part.direction)) nearest = m;
        sum[nearest] += part.solid_angle * part.radiance[channel];
        size[nearest] += part.solid_angle;
    }
    std::vector<float> radiance;
    for (size_t m = 0; m < towards.size(); ++m)
        radiance.push_back(float(size[m] > 0 ? sum[m] / size[m] : sky.radiance(towards[m])[channel]));
    return radiance;
}

}  // namespace

std::vector<float> sky_along(const VoxelIndex& index, const Sky& sky, int channel, const std::vector<Vec3d>& travel)
{
    std::vector<Vec3d> towards;
    for (const Vec3d& s : travel)
        towards.push_back(-(s[0] * index.axis(0) + s[1] * index.axis(1) + s[2] * index.axis(2)));
    if (!sky.parts().empty() && !towards.empty()) return means_about(towards, sky, channel);
    std::vector<float> radiance;
    for (const Vec3d& w : towards) radiance.push_back(float(sky.radiance(w)[channel]));
    return radiance;
}

}  // namespace vdbcloud
