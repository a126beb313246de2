#pragma once
// Sunlight that a clear atmosphere lets through: the attenuation that goes with the sky of scene/preetham.cc.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// Limits of turbidity, which is the optical depth of air with haze over that of air alone: from a very clear day to
/// thick haze. Below 2 the sky of preetham.cc shines along the horizon as no sky does (Zotti, Wilkie, Purgathofer
/// 2007).
constexpr double least_turbidity = 2, most_turbidity = 10;

/// Air on the way of the sun's light, 1 for a sun in the zenith: Kasten 1965. `height` of the sun above the horizon, 0
/// to 90 [degrees].
double relative_air_mass(double height);

/// Transmittance at a wavelength [nm], 380 to 750: Preetham, Shirley, Smits 1999, appendix A.1, by Rayleigh scattering,
/// haze of the turbidity (Angstrom's exponent 1.3) and 0.35 cm of ozone. Left out: water vapour and mixed gases, which
/// absorb beyond 690 nm, where the eye is nearly blind.
double atmosphere_transmittance(double wavelength, double air_mass, double turbidity);

/// Irradiance across the sun's beam, linear Rec. 709 [klx]: its luminance is the illuminance.
Vec3d sunlight_above_atmosphere();
Vec3d sunlight(double height, double turbidity);

}  // namespace vdbcloud
