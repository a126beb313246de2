#pragma once
// How much light is scattered more than once: what a picture of single scattering leaves out.
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/sky.h"

#include <array>
#include <vector>

namespace vdbcloud {

struct ShareOptions {
    double error = 0.005;  ///< more paths are taken until the standard error of the share is at or below this value
    int most_paths = 4096;
    /// No more paths are taken where the share is above this by 4 standard errors: what is asked for is on which side
    /// it is.
    double enough = 1;
    std::array<bool, 3> periodic{false, false, false};
};

struct ExpectedShare {
    double share = 0;  ///< in [0, 1); 0 where nothing scatters light of these sources
    double error = 0;  ///< standard error of `share`
    int paths = 0;
};

/// The share of all scattering that is not the first: with R_n the power that the medium scatters for the n-th time,
///
///     share = 1 - R_1 / (R_1 + R_2 + ...)
///
/// in the true medium, of light of `lights` and of `sky`. Thin media: albedo times the probability of a second
/// collision. In a closed medium without absorption the share tends to 1. Light of emission and of a ground is not
/// counted, and solids hide no light.
///
/// Method: light paths, so that phase function, shape and voids count. A path begins at a point drawn in proportion to
/// the density, weighted with the fluence of the sources there; it collides with certainty each time, with the
/// probability of the collision and the albedo as weight, and ends by Russian roulette, or after 1000 collisions. No
/// bias but that: the share is then too low where paths end so, by less than 1e-3 where R_1 is 1/1000 of the sum.
///
/// `tint` (Cd) multiplies the albedo; null for none. Channels that differ in extinction, albedo or tint: the largest of
/// their shares. Deterministic: the result does not depend on threads.
///
/// Errors: InputError for a transform that is not affine.
ExpectedShare expected_share(const FloatGrid& density, const Vec3SGrid* tint, const Medium&,
                             const std::vector<Light>& lights, const Sky& sky, const ShareOptions& = {});

}  // namespace vdbcloud
