#pragma once
// The blocks that a ray crosses. Private to sweep/.
#include "vdbcloud/core/fwd.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

inline constexpr double same_wall = 1e-7;  ///< walls this close [voxels] are met at once

/// A number of voxels as a whole number where they differ by rounding alone.
///
/// A characteristic along a diagonal begins at a centre of a voxel. Rounding must not give the voxel beside it a weight
/// of 1e-16: if the first voxel is void, q would be that of the second.
inline double snapped(double voxels)
{
    const double whole = std::round(voxels);
    return std::abs(voxels - whole) < same_wall ? whole : voxels;
}

/// A ray that goes from cell to cell of 2^bits blocks, against `step`. Coordinates are such that block b covers 8 b ..
/// 8 b + 8.
struct Walk {
    Vec3d from, step, inverse;
    Vec3i block;
    double t = 0;
    double wall[3];  // ray parameter at the next wall of each axis

    Walk(const Vec3d& point, const Vec3d& along) : from(point + Vec3d(0.5)), step(along)
    {
        for (int a = 0; a < 3; ++a) {
            inverse[a] = step[a] == 0 ? std::numeric_limits<double>::infinity() : 1 / step[a];
            block[a] = int(std::floor(from[a] / 8));
        }
        face_walls(0);
    }

    /// The current point, in voxels from its block's first voxel, after crossing walls of `axes`.
    double in_block(int axes, int a) const
    {
        return axes >> a & 1 ? (step[a] > 0 ? 7.5 : -0.5) : from[a] - t * step[a] - 0.5 - 8 * block[a];
    }

    void face_walls(int bits)
    {
        for (int a = 0; a < 3; ++a) {
            const int cell = block[a] >> bits;
            const double at = 8.0 * double((step[a] > 0 ? cell : cell + 1) * (int64_t(1) << bits));
            wall[a] = step[a] == 0 ? std::numeric_limits<double>::infinity() : (from[a] - at) * inverse[a];
        }
    }

    /// Crosses the nearest wall, or all walls that are met at once; returns their axes as bits.
    int cross(int bits)
    {
        t = std::min(wall[0], std::min(wall[1], wall[2]));
        int axes = 0;
        for (int a = 0; a < 3; ++a) {
            if ((wall[a] - t) * std::abs(step[a]) < same_wall) {  // in voxels
                axes |= 1 << a;
                const int cell = block[a] >> bits;
                block[a] = step[a] > 0 ? cell * (1 << bits) - 1 : (cell + 1) * (1 << bits);
                wall[a] += 8 * std::abs(inverse[a]);
            } else if (bits) {
                const int cell = block[a] >> bits;
                block[a] = std::clamp(int(std::floor((from[a] - t * step[a]) / 8)), cell * (1 << bits),
                                      (cell + 1) * (1 << bits) - 1);
            }
        }
        if (bits) face_walls(0);
        return axes;
    }
};

}  // namespace vdbcloud
