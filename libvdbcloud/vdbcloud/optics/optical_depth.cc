#include "vdbcloud/optics/optical_depth.h"

#include "vdbcloud/optics/cell_march.h"

namespace vdbcloud {

double density_depth(const BrickMap& density, const WorldRay& world, double t0, double t1)
{
    const IndexRay ray(density.index_from_world(), world);
    double sum = 0;
    march_pieces(density, ray, t0, t1, [&](double t_in, double t_out, const float* corners, const Vec3i& cell) {
        const Vec3d p = ray.at(t_in) - Vec3d(cell[0], cell[1], cell[2]);
        sum += (t_out - t_in) * along(corners, p, (t_out - t_in) * ray.direction).integral(1);
        return true;
    });
    return sum;
}

double depth_to_light(const BrickMap& density, const LightModel& light, const Vec3d& x)
{
    const Sight sight = light.towards(x);
    return sight.distance > 0 ? density_depth(density, {x, sight.direction}, 0, sight.distance) : 0;
}

}  // namespace vdbcloud
