#pragma once
// Real spherical harmonics: the basis in which radiance is expanded over directions.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// Position of Y_lm among all harmonics, by rising l and then m from -l to l.
constexpr int harmonic(int l, int m) { return l * (l + 1) + m; }
/// Number of harmonics up to `degree`.
constexpr int harmonic_count(int degree) { return (degree + 1) * (degree + 1); }

/// Y_lm(s), l = 0..degree, real and orthonormal over the sphere, for the unit vector `s`; `y` takes
/// harmonic_count(degree) values. No Condon-Shortley sign, so that Y_00 = 1/sqrt(4 pi) and
/// (Y_1-1, Y_10, Y_11) = sqrt(3/(4 pi)) (y, z, x).
void evaluate_harmonics(int degree, const Vec3d& s, double* y);

}  // namespace vdbcloud
