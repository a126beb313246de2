#pragma once
// Where a ray collides with a medium: free paths distributed as exp(-tau), by exact inversion of the optical depth.
#include "vdbcloud/optics/cell_march.h"

namespace vdbcloud {

/// How far a ray got through one grid.
struct Travel {
    bool reached;    ///< the density depth that was asked for lies on the ray
    double t;        ///< distance at which it is reached, else the end of the ray [world unit]
    double depth;    ///< density depth from the ray's start to t [density x world unit]
    double density;  ///< at t, where it is reached
};

/// The point of the ray, t0 <= t <= t1, at which the integral of density from t0 reaches `depth` > 0.
///
/// The density along the ray is a cubic in each cell of the trilinear interpolant, so the depth is a quartic, which is
/// increasing: bracketed Newton steps solve it to rounding (1e-14 of the cell). With `depth` = -log(1 - u) / sigma_t,
/// u uniform, t has the distribution of free paths exactly. The cost is that of the nonempty cells up to t.
/// `density` must be >= 0 everywhere. Threads: no state.
Travel travel(const BrickMap& density, const IndexRay&, double t0, double t1, double depth);

/// The density depth of t0..t1, or any number above `most` as soon as the depth exceeds `most`.
double depth_up_to(const BrickMap& density, const IndexRay&, double t0, double t1, double most);

}  // namespace vdbcloud
