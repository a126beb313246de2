#pragma once
// Light that was scattered at least once, as grids: what p1solve writes into a file and pictures gather.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/optics/delta_scaling.h"

#include <array>
#include <functional>
#include <vector>

namespace vdbcloud {

/// Collided light of a medium with delta scaling. All grids have one transform; harmonics and vectors are about the
/// world's axes; values are radiance x sr.
///
/// Where the three channels are multiples of one solution they share its grids: phi is a float grid, the three fluxes
/// are one grid, the three lists of moments hold the same grids, and channel_scale times them is r, g, b. Else phi is
/// vec3s and channel_scale is 1, 1, 1.
struct CollidedLight {
    GridBasePtr phi;                   ///< fluence, integral of radiance over the sphere; null: there is no light
    std::array<Vec3SGridPtr, 3> flux;  ///< integral of direction times radiance, of r, g, b; may be null
    /// Moments of degree 2 and more of r, g, b, by rising l and m from -l to l (optics/spherical_harmonics.h).
    std::array<std::vector<FloatGridPtr>, 3> moments;
    Vec3d channel_scale{1, 1, 1};
    /// Pictures shorten the flux, where it is longer, to this times phi; 0: they do not. P1's radiance
    /// phi + 3 s.F is negative in some direction where |F| > phi / 3. The grids are never shortened: light adds up.
    double flux_limit = 0;
    DeltaScaling scaling;  ///< of the medium that the light belongs to
};

/// phi of all three channels as a grid of vectors, scaled; null for null.
Vec3SGridPtr fluence(const CollidedLight&);
/// The flux of one channel, 0, 1, 2, scaled; null for null.
Vec3SGridPtr flux_of(const CollidedLight&, int channel);

/// Names the grids as grid/registry.h says, and writes scaling, channel_scale and flux_limit into the metadata of each;
/// `stamp` adds what else they have in common: medium, lights, sources.
void name_collided_light(const CollidedLight&, const std::function<void(GridBase&)>& stamp);

/// Removes an earlier solution from a file and puts the grids that a picture weighs: phi; flux where m_1' is not 0;
/// moments up to the last degree whose m_l' is not 0.
void put_collided_light(GridFile&, const CollidedLight&);

/// The fluence among a file's grids: a grid `phi` of vec3s, or of floats with channel_scale. Null without one; other
/// programs call other things phi, a signed distance for example.
GridBasePtr fluence_grid(const GridFile&);

/// The collided light of a file; phi is null without one. Moments end before the first degree of which one is missing,
/// with a warning if that degree has m_l' other than 0. `phase` serves files without moments of the scaled medium.
/// Throws InputError for a grid of another type than docs/format.md has.
CollidedLight read_collided_light(const GridFile&, const PhaseFunction& phase, const Warn&);

}  // namespace vdbcloud
