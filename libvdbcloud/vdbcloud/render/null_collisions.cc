#include "vdbcloud/render/null_collisions.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr int corners_of_brick = 729;

/// The interpolant within a brick whose corner values are c; p: from the brick's first corner, in cells.
double interpolated(const float* c, const Vec3d& p)
{
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    const int i = std::clamp(int(p[0]), 0, 7), j = std::clamp(int(p[1]), 0, 7), k = std::clamp(int(p[2]), 0, 7);
    const double x = p[0] - i, y = p[1] - j, z = p[2] - k;
    const float* v = c + i * sx + j * sy + k;
    const auto along_z = [&](int at) { return v[at] + z * (double(v[at + 1]) - v[at]); };
    const double low = along_z(0) + y * (along_z(sy) - along_z(0)),
                 high = along_z(sx) + y * (along_z(sx + sy) - along_z(sx));
    return low + x * (high - low);
}

/// The mean of the interpolant of eight corners over m - d / 2 .. m + d / 2, in the cell's own coordinates: the
/// integral of the cubic, exact. Cubic::integral() without the coefficients that the integral does not have.
double mean_along(const float* c, const Vec3d& m, const Vec3d& d)
{
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    const double v000 = c[0], v001 = c[1], v010 = c[sy], v011 = c[sy + 1];
    const double v100 = c[sx], v101 = c[sx + 1], v110 = c[sx + sy], v111 = c[sx + sy + 1];
    // f = a + b.p + e_x y z + e_y x z + e_z x y + h x y z
    const double bx = v100 - v000, by = v010 - v000, bz = v001 - v000;
    const double ez = v110 - v100 - by, ey = v101 - v100 - bz, ex = v011 - v010 - bz;
    const double h = v111 - v110 - v101 + v100 - ex, yz = ex + h * m[0];
    return v000 + bx * m[0] + m[1] * (by + ez * m[0]) + m[2] * (bz + ey * m[0] + yz * m[1]) +
           (d[0] * (d[1] * (ez + h * m[2]) + d[2] * (ey + h * m[1])) + d[1] * d[2] * yz) / 12;
}

/// Density depth of t..t1, which lies within the brick of corner values c and first cell `first`; or a part of it above
/// `most`. The loop of march_cells() without its calls: most of a path's time is spent here.
double depth_in_brick(const float* c, const IndexRay& ray, const Vec3i& first, double t, double t1, double most)
{
    constexpr int strides[] = {BrickMap::sx, BrickMap::sy, 1};
    const Vec3d origin = ray.origin - Vec3d(first[0], first[1], first[2]), &d = ray.direction;
    int cell[3];
    double next[3], across[3];
    for (int a = 0; a < 3; ++a) {
        cell[a] = std::clamp(int(origin[a] + t * d[a]), 0, BrickMap::size - 1);
        c += cell[a] * strides[a];
        next[a] = d[a] == 0 ? std::numeric_limits<double>::infinity()
                            : (cell[a] + int(d[a] > 0) - origin[a]) * ray.inverse[a];
        across[a] = std::abs(ray.inverse[a]);
    }
    double sum = 0;
    for (;;) {
        const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const double t_out = std::min(next[a], t1);
        if (t_out > t) {
            const double length = t_out - t;
            const Vec3d middle = origin + (t + 0.5 * length) * d - Vec3d(cell[0], cell[1], cell[2]);
            sum += length * mean_along(c, middle, length * d);
            t = t_out;
        }
        if (t >= t1 || sum > most) return sum;
        const int step = d[a] > 0 ? 1 : -1;
        cell[a] += step;
        if (cell[a] < 0 || cell[a] >= BrickMap::size) return sum;
        c += step * strides[a];
        next[a] += across[a];
    }
}

}  // namespace

NullCollisions::NullCollisions(const BrickMap& density) : map_(&density)
{
    for (const Vec3i& b : density.bricks()) {
        const float* c = density.find(b);
        const auto slot = size_t(c - density.brick(0)) / corners_of_brick;
        if (slot >= majorants_.size()) majorants_.resize(slot + 1, 0.0f);
        majorants_[slot] = *std::max_element(c, c + corners_of_brick);
    }
}

double NullCollisions::depth_up_to(const IndexRay& ray, double t0, double t1, double most) const
{
    double sum = 0;
    march_bricks(*map_, ray, t0, t1, [&](double t_in, double t_out, int32_t slot, const Vec3i& cell) {
        sum += map_->constant(slot) ? (t_out - t_in) * double(majorants_[size_t(slot)])
                                    : depth_in_brick(map_->brick(slot), ray, cell, t_in, t_out, most - sum);
        return sum <= most;
    });
    return sum;
}

bool NullCollisions::collide(const IndexRay& ray, double t0, double t1, double sigma_t, PathRandom& random,
                             Hit& hit) const
{
    // Density depth to the next tentative collision: exponential, so what is left at a brick's end goes on in the next.
    double depth = -std::log1p(-random.next()) / sigma_t;
    bool real = false;
    march_bricks(*map_, ray, t0, t1, [&](double t, double t_out, int32_t slot, const Vec3i& cell) {
        const double majorant = majorants_[size_t(slot)];
        if (!(majorant > 0)) return true;
        const float* corners = map_->brick(slot);
        const Vec3d first(cell[0], cell[1], cell[2]);
        for (;;) {
            const double step = depth / majorant;
            if (t + step >= t_out) {
                depth -= (t_out - t) * majorant;
                return true;
            }
            t += step;
            const double density = interpolated(corners, ray.at(t) - first);
            if (random.next() * majorant < density) {
                hit = {t, density};
                real = true;
                return false;
            }
            depth = -std::log1p(-random.next()) / sigma_t;
        }
    });
    return real;
}

}  // namespace vdbcloud
