#pragma once
// Colours of spectra: CIE 1931 tristimulus values and linear Rec. 709.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// CIE 1931 2 degree colour matching functions at a wavelength [nm]: the table of CIE 015:2018 at 380, 390 ... 780 nm,
/// linear between; 0 beyond.
Vec3d colour_matching(double wavelength);

/// Lumens in a watt of a spectrum that was weighted by the second of the colour matching functions.
constexpr double luminous_efficacy = 683;

/// Luminance of linear Rec. 709 (white point D65), which is Y of rec709_of_xyz().
double luminance(const Vec3d& rec709);

/// Linear Rec. 709 of X, Y, Z. Colours outside its gamut: negative channels become 0, and the others are scaled so that
/// the luminance is kept.
Vec3d rec709_of_xyz(const Vec3d& xyz);

/// X, Y, Z of a chromaticity x, y and Y.
Vec3d xyz_of_chromaticity(double x, double y, double Y);

}  // namespace vdbcloud
