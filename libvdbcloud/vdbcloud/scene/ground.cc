#include "vdbcloud/scene/ground.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/extent.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double far = std::numeric_limits<double>::infinity();

/// The least height of the density's interpolant; infinity for one that is 0.
double lowest(const FloatGrid& density, const Vec3d& up)
{
    double least = far;
    for (const Vec3d& corner : interpolant_corners(density)) least = std::min(least, corner.dot(up));
    return least;
}

}  // namespace

double Ground::distance(const WorldRay& ray) const
{
    const double fall = -ray.direction.dot(up);
    return fall > 0 ? std::max(height(ray.origin), 0.0) / fall : far;
}

Ground ground_beneath(const std::vector<const FloatGrid*>& densities, const Vec3d& up, double albedo)
{
    check_ground_albedo(albedo);
    double least = far;
    for (const FloatGrid* density : densities) least = std::min(least, lowest(*density, up));
    return {albedo, least < far ? least * up : Vec3d(0), up};
}

void check_ground_albedo(double albedo)
{
    if (!(albedo >= 0 && albedo <= 1))
        throw InputError("albedo of the ground " + std::to_string(albedo) + ": expected 0 to 1");
}

void require_light_above(const Light& light, const Ground& ground)
{
    const auto source = light->source();
    const Vec3d way = source ? source->position - ground.point : light->towards(ground.point).direction;
    if (!(way.dot(ground.up) > 0))
        throw InputError("light '" + light.name + "' is not above the ground: expected one that shines down on it");
}

}  // namespace vdbcloud
