#include "vdbcloud/optics/free_path.h"

namespace vdbcloud {

namespace {

/// The s in [0, 1] at which rho.integral(s) is `part`, 0 <= part <= rho.integral(1).
double inverse_integral(const Cubic& rho, double part, double whole)
{
    double low = 0, high = 1, s = part / whole;
    for (int step = 0; step < 60; ++step) {
        const double excess = rho.integral(s) - part;
        (excess > 0 ? high : low) = s;
        const double slope = rho.at(s), next = slope > 0 ? s - excess / slope : -1;
        const double better = next > low && next < high ? next : (low + high) / 2;
        if (std::abs(better - s) < 1e-14) return better;
        s = better;
    }
    return s;
}

}  // namespace

Travel travel(const BrickMap& density, const IndexRay& ray, double t0, double t1, double depth)
{
    Travel out{false, t1, 0, 0};
    march_cells(density, ray, t0, t1, [&](double t_in, double t_out, const float* corners, const Vec3i& cell) {
        const Vec3d p = ray.at(t_in) - Vec3d(cell[0], cell[1], cell[2]);
        const double length = t_out - t_in;
        const Cubic rho = along(corners, p, length * ray.direction);
        const double whole = rho.integral(1);
        if (out.depth + length * whole <= depth) {
            out.depth += length * whole;
            return true;
        }
        const double s = inverse_integral(rho, (depth - out.depth) / length, whole);
        out = {true, t_in + s * length, depth, rho.at(s)};
        return false;
    });
    return out;
}

double depth_up_to(const BrickMap& density, const IndexRay& ray, double t0, double t1, double most)
{
    double sum = 0;
    march_cells(density, ray, t0, t1, [&](double t_in, double t_out, const float* corners, const Vec3i& cell) {
        const Vec3d p = ray.at(t_in) - Vec3d(cell[0], cell[1], cell[2]);
        sum += (t_out - t_in) * along(corners, p, (t_out - t_in) * ray.direction).integral(1);
        return sum <= most;
    });
    return sum;
}

}  // namespace vdbcloud
