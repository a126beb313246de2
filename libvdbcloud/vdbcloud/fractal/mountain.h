#pragma once
// A fractal mountain: a height field, and the solid below it as a level set.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/fractal/envelope.h"
#include "vdbcloud/fractal/noise.h"

#include <vector>

namespace vdbcloud {

/// How noise n of two dimensions makes heights: with b = (1 - ridges) n - ridges 2 |n|, scaled to B in 0..1
/// over the field, and the mound m = (1 - r^2)^(3/2), r = 1 at the edges of the box,
///
///     q = (1 - peak (1 - m)) (a + (1 - a) B),   a = 0.1 peak
///     height = ground + relief (q - q_min) / (q_max - q_min)
struct MountainOptions {
    double relief = 0.35;   ///< from the lowest to the highest point, over the longest horizontal side; > 0
    double ridges = 0.6;    ///< 0: rolling land, 1: sharp ridges and round valleys
    double peak = 1;        ///< 0: as high at the edges of the box as in the middle, 1: one mountain
    double half_width = 3;  ///< of the narrow band [voxels], 1.5..16
    int up = 1;             ///< axis that points up: 0, 1 or 2
};

/// Heights [world, along the up axis] over the voxel columns of a domain, in the order of the two other axes,
/// second fastest.
struct HeightField {
    int up = 1;
    Box domain;
    Vec3i size{0, 0, 0};  ///< of the domain [voxels]; size[up] is not used
    std::vector<float> height;
    int rows() const { return size[up == 0 ? 1 : 0]; }
    int columns() const { return size[up == 2 ? 1 : 2]; }
};

/// Heights above a ground of four voxels at the low face of the domain, at most up to its high face (then the
/// relief is less). Threads: all of TBB's; values do not depend on them. Throws InputError.
HeightField mountain_heights(const Box& domain, const Vec3i& size, const Spectrum&, const MountainOptions&);

/// The body between the heights and the low face of the domain, with upright walls at its sides, as a level
/// set named by the schema: signed distance to its surface of two triangles a column [world], negative
/// inside, within half_width voxels. Voxels must be cubes, else InputError.
FloatGridPtr mountain_grid(const HeightField&, double half_width);

}  // namespace vdbcloud
