#pragma once
// Light of hot matter: Planck's spectrum as a colour.
#include "vdbcloud/core/fwd.h"

#include <vector>

namespace vdbcloud {

/// Below this temperature [K] matter is taken not to shine: its radiance is below 1e-14 of the unit. It begins to be
/// seen in the dark at 798 K, the Draper point.
constexpr double coldest_light = 500;

/// Spectral radiance of a black body [W m^-2 sr^-1 nm^-1] at a wavelength [nm] and a temperature [K], by Planck's law
/// with the constants of the SI of 2019. 0 at temperatures of 0 and below.
double planck(double wavelength, double temperature);

/// X, Y, Z of a black body: planck() times colour_matching(), integrated from 380 to 780 nm [W m^-2 sr^-1].
Vec3d blackbody_xyz(double temperature);

/// Radiance of a black body in linear Rec. 709, in units of unit_of_light(). Bodies below some 1900 K are redder than
/// Rec. 709 can show: their blue is 0 and their luminance is kept (rec709_of_xyz()). 0 below coldest_light.
Vec3d blackbody(double temperature);

/// blackbody() from a table, for many temperatures: relative error below 1e-5. Temperatures above `hottest` are
/// computed. Threads may share a table.
class BlackbodyTable {
public:
    explicit BlackbodyTable(double hottest);
    Vec3d operator()(double temperature) const;

private:
    double step_;                ///< of the logarithm of temperature
    std::vector<Vec3d> values_;  ///< log(X, Y, Z) + c / T, which is nearly a straight line
};

}  // namespace vdbcloud
