#pragma once
// What is behind the medium: nothing, one radiance, or a sky that changes with height.
#include "vdbcloud/core/fwd.h"

#include <optional>

namespace vdbcloud {

/// Radiance from infinity, a function of the angle to `up` alone. With s = dot(w, up), w pointing AWAY from
/// the viewer (the direction of a camera ray, so against the light's propagation):
///
///     s >= 0:  L = zenith + (horizon - zenith) (1 - s)^haze
///     s <  0:  L = ground + (horizon - ground) (1 + s)^haze
///
/// Continuous at the horizon. All three colours equal: a constant background.
struct Sky {
    Vec3d zenith{0, 0, 0};
    Vec3d horizon{0, 0, 0};
    Vec3d ground{0, 0, 0};
    double haze = 4;    ///< how narrow the band along the horizon is, >= 0; 4: half gone 9 degrees above it
    Vec3d up{0, 1, 0};  ///< unit
    /// Dark where s < 0, for a ground hides the sky there. Not stored with a grid, which tells its ground by itself.
    bool ends_at_horizon = false;

    /// The same radiance everywhere.
    static Sky constant(const Vec3d& radiance);

    /// A clear blue day: for a sun of irradiance E perpendicular to its beam, a zenith of about E/40 in blue
    /// and a paler horizon.
    static Sky clear_day(const Vec3d& sun_irradiance, const Vec3d& up);

    /// L in a direction, unit.
    Vec3d radiance(const Vec3d& direction) const;

    /// The mean of L over the half of directions with dot(w, normal) > 0, weighted with that cosine: pi times it is the
    /// irradiance of a surface that looks along `normal` (unit). By quadrature in height, exact around it; relative
    /// error below 1e-5, none for a constant sky.
    Vec3d mean_inflow(const Vec3d& normal) const;

    /// The same in all directions: `up` and `haze` do not matter.
    bool uniform() const { return zenith == horizon && horizon == ground && !ends_at_horizon; }
    bool dark() const { return zenith == Vec3d(0.0) && horizon == Vec3d(0.0) && ground == Vec3d(0.0); }

    /// The mean of L over the sphere, in closed form. A uniform sky of it sends a ball the same power;
    /// other bodies need mean_inflow() for each face.
    Vec3d mean_radiance() const;
};

/// True for the same parameters.
bool operator==(const Sky&, const Sky&);

/// Throws InputError unless every radiance is finite and 0 or above, haze finite and 0 or above, up of some
/// length.
void check(const Sky&);

/// Writes the sky that lit a grid into its metadata (schema::lit_sky ...), and reads it back: none if there is none or
/// it is black. Reading throws InputError as check().
void write_sky(MetaMap&, const Sky&);
std::optional<Sky> read_sky(const MetaMap&);

}  // namespace vdbcloud
