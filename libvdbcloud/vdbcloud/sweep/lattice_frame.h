#pragma once
// The light lattice's own axes, and what one step along them integrates. Private to sweep/.
#include "vdbcloud/voxels/brick_map.h"

#include <vector>

namespace vdbcloud {

/// Index space turned so that light travels along +w: index[axis.w] = sign * w, slopes |mu|, |mv| <= 1.
struct LatticeFrame {
    int u, v, w;        // which index axes
    int sign;           // of index[w] along w
    double mu, mv;      // du/dw, dv/dw along a ray
    double length;      // world units per unit of w
    double ou, ov, ow;  // offset of the targets [voxels]
};

/// The frame along the axis that light crosses fastest, or each of these axes where light is as fast along two or
/// three.
std::vector<LatticeFrame> frames_of(const BrickMap& density, const Vec3d& to_light, const Vec3d& offset);

/// One voxel's part in the integral over a plane step: value at ray's integer position + (du, dv), plane dw.
struct LatticeTap {
    int du, dv, dw;
    double weight;
};

/// The exact integral of trilinear density from (u0, v0, w0) along (mu, mv, 1) over s in [0, 1], as taps. Between two
/// walls the density is a cubic in s, for which two Gauss points are exact.
std::vector<LatticeTap> step_taps(const LatticeFrame& f, double u0, double v0, double w0);

/// The mean number of taps of a step: a ray of each phase, at 16 places between planes.
double mean_taps(const LatticeFrame& f, int rays_per_voxel);

}  // namespace vdbcloud
