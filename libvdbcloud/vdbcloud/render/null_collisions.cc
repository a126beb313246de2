#include "vdbcloud/render/null_collisions.h"

#include <algorithm>
#include <cmath>

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
