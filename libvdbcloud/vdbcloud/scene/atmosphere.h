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
/// The unit of all radiances, irradiances and intensities: a white light of irradiance 1 has the illuminance of the sun
/// above the atmosphere [klx], and a white radiance of 1 that luminance [klx/sr, 1000 cd/m^2]. In watts, weighted by
/// the second colour matching function, 1 is unit_of_light() / luminous_efficacy * 1000 W/m^2 (and per steradian).
double unit_of_light();
Vec3d sunlight(double height, double turbidity);

}  // namespace vdbcloud
