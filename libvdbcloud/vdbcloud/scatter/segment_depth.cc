#include "vdbcloud/scatter/segment_depth.h"

#include "vdbcloud/optics/cell_march.h"

#include <algorithm>

namespace vdbcloud {

namespace {

constexpr size_t corners_of_brick = 729;

}  // namespace

SegmentDepth::SegmentDepth(const BrickMap& density, double extinction) : density_(density), extinction_(extinction)
{
    for (const Vec3i& at : density.bricks()) {
        const float* values = density.find(at);
        const size_t slot = size_t(values - density.brick(0)) / corners_of_brick;
        if (uniform_.size() <= slot) uniform_.resize(slot + 1);
        uniform_[slot] = std::all_of(values, values + corners_of_brick, [&](float v) { return v == values[0]; });
    }
}

double SegmentDepth::operator()(const Vec3d& a, const Vec3d& b, double most) const
{
    const Vec3d apart = b - a;
    const double length = apart.length();
    if (!(length > 0)) return 0;
    const WorldRay world{a, apart / length};
    const IndexRay ray(density_.index_from_world(), world);
    const double enough = most / extinction_;
    double sum = 0;
    const auto cell = [&](double t_in, double t_out, const float* corners, const Vec3i& at) {
        const Vec3d p = ray.at(t_in) - Vec3d(at[0], at[1], at[2]);
        sum += (t_out - t_in) * along(corners, p, (t_out - t_in) * ray.direction).integral(1);
        return sum < enough;
    };
    march_detail::march_roots(density_, ray, 0, length, [&](int32_t number, Vec3i& at, double& t) {
        const int32_t slot = density_.slot(number);
        if (!uniform_[size_t(slot)]) return march_detail::march_brick(density_.brick(slot), ray, at, t, length, cell);
        int axis = 0;
        const double exit = march_detail::exit_of(ray, at, 3, axis);
        sum += std::max(std::min(exit, length) - t, 0.0) * density_.brick(slot)[0];
        t = std::max(t, exit);
        if (t < length) march_detail::leave(ray, at, 3, axis, t);
        return sum < enough;
    });
    return extinction_ * sum;
}

}  // namespace vdbcloud
