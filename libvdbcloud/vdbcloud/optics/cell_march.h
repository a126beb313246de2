#pragma once
// Walks a ray through the nonempty cells of a brick map. Inside one cell the trilinear density along a ray is a cubic
// polynomial, so its integral over the cell is exact.
#include "vdbcloud/voxels/brick_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace vdbcloud {

/// A world ray in the index space of one grid. The parameter t is the distance in world units.
struct IndexRay {
    IndexRay(const Affine& index_from_world, const WorldRay& ray)
        : origin(index_from_world.point(ray.origin)), direction(index_from_world.vector(ray.direction))
    {
        for (int a = 0; a < 3; ++a) inverse[a] = direction[a] != 0 ? 1 / direction[a] : 0;
    }
    Vec3d at(double t) const { return origin + t * direction; }

    Vec3d origin, direction, inverse;
};

/// Narrows [t0, t1] to the part of the ray inside the box lo..hi; false if that part is empty. A ray that runs within a
/// face is inside at lo and outside at hi, so such a ray meets only one of two adjacent boxes.
inline bool clip(const IndexRay& ray, const Vec3d& lo, const Vec3d& hi, double& t0, double& t1)
{
    for (int a = 0; a < 3; ++a) {
        if (ray.direction[a] == 0) {
            if (ray.origin[a] < lo[a] || ray.origin[a] >= hi[a]) return false;
            continue;
        }
        const double p = (lo[a] - ray.origin[a]) * ray.inverse[a], q = (hi[a] - ray.origin[a]) * ray.inverse[a];
        t0 = std::max(t0, std::min(p, q));
        t1 = std::min(t1, std::max(p, q));
    }
    return t0 < t1;
}

/// A ray through a map that repeats ends after it has crossed this many periods. Only rays within about 1e-5 of the
/// axes along which the map repeats get so far, and only where little or nothing is in their way.
constexpr double most_periods = 100000;

/// Narrows [t0, t1] to the part of the ray that can meet cells of the map; false if that part is empty. t1 is finite on
/// return.
inline bool clip(const IndexRay& ray, const BrickMap& map, double& t0, double& t1)
{
    constexpr double far = std::numeric_limits<double>::infinity();
    if (map.empty()) return false;
    Vec3d lo, hi;
    for (int a = 0; a < 3; ++a) {
        const bool ends = map.period().length[a] == 0;
        lo[a] = ends ? map.first_cell()[a] : -far;
        hi[a] = ends ? map.last_cell()[a] + 1.0 : far;
    }
    if (!clip(ray, lo, hi, t0, t1)) return false;
    double periods = 0;  // for each unit of t
    for (int a = 0; a < 3; ++a)
        if (map.period().length[a] > 0) periods += std::abs(ray.direction[a]) / map.period().length[a];
    if (periods > 0) t1 = std::min(t1, t0 + most_periods / periods);
    return t0 < t1;
}

/// Density along a segment of a ray inside one cell: c0 + c1 s + c2 s^2 + c3 s^3, s in [0, 1] from t_in to t_out.
struct Cubic {
    double c0, c1, c2, c3;

    double at(double s) const { return c0 + s * (c1 + s * (c2 + s * c3)); }
    /// Integral from 0 to s [density], exact.
    double integral(double s) const { return s * (c0 + s * (c1 / 2 + s * (c2 / 3 + s * (c3 / 4)))); }
};

/// The trilinear interpolant of eight corners (BrickMap's order) along p + s d, p in the cell's own coordinates.
inline Cubic along(const float* c, const Vec3d& p, const Vec3d& d)
{
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    const double v000 = c[0], v001 = c[1], v010 = c[sy], v011 = c[sy + 1];
    const double v100 = c[sx], v101 = c[sx + 1], v110 = c[sx + sy], v111 = c[sx + sy + 1];
    // f = a + b.p + e_x y z + e_y x z + e_z x y + h x y z
    const double bx = v100 - v000, by = v010 - v000, bz = v001 - v000;
    const double ez = v110 - v100 - by, ey = v101 - v100 - bz, ex = v011 - v010 - bz;
    const double h = v111 - v110 - v101 + v100 - ex;
    const double x = p[0], y = p[1], z = p[2], dx = d[0], dy = d[1], dz = d[2];
    const double yz = ex + h * x, xz = ey + h * y, xy = ez + h * z;
    return {v000 + bx * x + y * (by + ez * x) + z * (bz + ey * x + yz * y),
            dx * (bx + ez * y + z * xz) + dy * (by + ez * x + z * yz) + dz * (bz + ey * x + y * yz),
            dx * dy * xy + dx * dz * xz + dy * dz * yz, h * dx * dy * dz};
}

/// Calls visit(t_in, t_out, corners, cell) for each cell that the ray crosses between t0 and t1, in order, where any
/// corner is not 0; corners points to the cell's first corner value. Stops when visit returns false. A brick of zeros
/// costs one step.
///
/// Each cell is visited once, up to rounding: a ray through an edge or a corner may visit cells over lengths of 1e-15,
/// whose integral is negligible. Brick borders are ordinary cell borders. Source: Amanatides & Woo 1987; distances to
/// the planes are recomputed at each step, so that long rays do not accumulate rounding.
///
/// A map that repeats is visited copy by copy, up to 2^30 cells from the first one: `cell` is the cell on the ray,
/// map.period().home(cell) the cell of the map.
template<typename Visit>
bool march_cells(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit);

/// As march_cells(), but a brick of one value is visited once, as if it were one cell: for what depends on the density
/// alone. A ray through a tile of n voxels a side takes about n/8 steps.
template<typename Visit>
bool march_pieces(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit);

/// The steps of march_pieces(): nonempty cells, bricks of one value, and boxes of emptiness, the larger the emptier.
inline size_t count_steps(const BrickMap& map, const IndexRay& ray, double t0, double t1);

/// Calls visit(t_in, t_out, slot, cell) for each brick that the ray crosses between t0 and t1, in order; slot: for
/// BrickMap::brick(); cell: the brick's first, on the ray as for march_cells(). Stops when visit returns false.
template<typename Visit>
bool march_bricks(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit);

#include "vdbcloud/optics/cell_march.inl"

}  // namespace vdbcloud
