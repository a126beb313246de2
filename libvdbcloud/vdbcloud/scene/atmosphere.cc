#include "vdbcloud/scene/atmosphere.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scene/colour.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr int samples = 38;
constexpr double first_wavelength = 380, step = 10;  // [nm]

/// Radiance of the sun above the atmosphere [10 W / (cm^2 um sr)], and absorption of ozone [1/cm], at 380, 390 ... 750
/// nm: Preetham, Shirley, Smits 1999, table 2.
constexpr double solar[samples] = {165.5, 162.3, 211.2, 258.8, 258.2, 242.3, 267.6, 296.6, 305.4, 300.6,
                                   306.6, 288.3, 287.1, 278.2, 271.0, 272.3, 263.6, 255.0, 250.6, 253.1,
                                   253.5, 251.3, 246.3, 241.7, 236.8, 232.1, 228.2, 223.4, 219.7, 215.3,
                                   211.0, 207.3, 202.4, 198.7, 194.3, 190.7, 186.3, 182.6};
constexpr double ozone[samples] = {0,     0,     0,     0,     0,     0,     0,     0.003, 0.006, 0.009,
                                   0.014, 0.021, 0.030, 0.040, 0.048, 0.063, 0.075, 0.085, 0.103, 0.120,
                                   0.120, 0.115, 0.125, 0.120, 0.105, 0.090, 0.079, 0.067, 0.057, 0.048,
                                   0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.010, 0.009};

constexpr double solid_angle = 6.7443e-5;                                  // of the sun [sr]
constexpr double luminous = luminous_efficacy * solid_angle * 1e5 * 1e-3;  // [klx per 10 W / (cm^2 um sr) um]

double ozone_absorption(double wavelength)
{
    const double at = std::fmin(std::fmax((wavelength - first_wavelength) / step, 0), samples - 1);
    const int below = std::min(int(at), samples - 2);
    return ozone[below] + (ozone[below + 1] - ozone[below]) * (at - below);
}

template<typename Transmittance>
Vec3d sum(const Transmittance& transmittance)
{
    Vec3d xyz(0.0);
    for (int k = 0; k < samples; ++k) {
        const double wavelength = first_wavelength + step * k;
        xyz += luminous * step * 1e-3 * solar[k] * transmittance(wavelength) * colour_matching(wavelength);
    }
    return rec709_of_xyz(xyz);
}

}  // namespace

double relative_air_mass(double height)
{
    return 1 / (std::sin(height * pi / 180) + 0.15 * std::pow(height + 3.885, -1.253));
}

double atmosphere_transmittance(double wavelength, double air_mass, double turbidity)
{
    constexpr double ozone_layer = 0.35;  // [cm]
    const double micrometres = wavelength * 1e-3, haze = 0.04608 * turbidity - 0.04586;
    return std::exp(-air_mass * (0.008735 * std::pow(micrometres, -4.08) + haze * std::pow(micrometres, -1.3) +
                                 ozone_layer * ozone_absorption(wavelength)));
}

Vec3d sunlight_above_atmosphere()
{
    return sum([](double) { return 1.0; });
}

double unit_of_light()
{
    static const double unit = luminance(sunlight_above_atmosphere());
    return unit;
}

Vec3d sunlight(double height, double turbidity)
{
    const double mass = relative_air_mass(height);
    return sum([&](double wavelength) { return atmosphere_transmittance(wavelength, mass, turbidity); });
}

}  // namespace vdbcloud
