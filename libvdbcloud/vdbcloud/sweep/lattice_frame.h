#pragma once
// The light lattice's own axes, and what one step along them integrates. Private to sweep/.
#include "vdbcloud/voxels/brick_map.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// Index space turned so that light travels along +w: index[axis.w] = sign * w, slopes |mu|, |mv| <= 1.
struct LatticeFrame {
    int u, v, w;    // which index axes
    int sign;       // of index[w] along w
    double mu, mv;  // du/dw, dv/dw along a ray
    double length;  // world units per unit of w
};

/// The frame along the axis that light crosses fastest, or each of these axes where light is as fast along two or
/// three.
std::vector<LatticeFrame> frames_of(const BrickMap& density, const Vec3d& to_light);

/// Where targets at voxel centre + an offset lie: at voxel + (u, v) across the light, on plane w = voxel + shift +
/// fraction.
struct LatticeOffset {
    LatticeOffset(const LatticeFrame&, const Vec3d& offset);
    double u, v;
    int shift;
    double fraction;  // in [0, 1)
};

/// The fractions of some offsets, rising, each once: where rays stop between two planes of voxels.
std::vector<double> stops_of(const std::vector<LatticeOffset>&);
/// The stop of an offset.
size_t stop_of(const std::vector<double>& stops, const LatticeOffset&);

/// One voxel's part in the integral over a step: value at ray's integer position + (du, dv), plane dw.
struct LatticeTap {
    int du, dv, dw;
    double weight;
};
struct LatticeTaps {
    static constexpr int most = 64;
    int count = 0;
    std::array<LatticeTap, most> tap;
};

/// The exact integral of trilinear density from (u0, v0, w0) along (mu, mv, 1) over s in [0, step], step <= 1, as taps.
/// Between two walls the density is a cubic in s, for which two Gauss points are exact.
LatticeTaps step_taps(const LatticeFrame& f, double u0, double v0, double w0, double step = 1);

/// Where a step to a stop begins (relative to plane n, so below 0 for the first), and its length.
struct LatticeStep {
    double from, length;
    LatticeStep(const std::vector<double>& stops, size_t stop)
        : from(stop > 0 ? stops[stop - 1] : stops.back() - 1), length(stops[stop] - from)
    {
    }
};

/// The mean number of taps from plane to plane: a ray of each phase, at 16 places between planes.
double mean_taps(const LatticeFrame& f, const std::vector<double>& stops, int rays_per_voxel);

}  // namespace vdbcloud
