#pragma once
// Multiplication by the direction in real spherical harmonics: the streaming operator, and P1 as its truncation.
#include "vdbcloud/optics/spherical_harmonics.h"

#include <vector>

namespace vdbcloud {

/// <row| s_axis |column>: multiplication by one Cartesian component of the direction, in the real orthonormal basis of
/// optics/spherical_harmonics.h.
///
/// Row-major, harmonic_count(degree) squared. Symmetric; an entry is zero unless the two degrees differ by one.
/// With a_lm = sqrt(((l+1)^2 - m^2) / ((2l+1)(2l+3))), z takes (l, m) to a_lm (l+1, m) + a_{l-1,m} (l-1, m); x and y
/// change m by one. The streaming operator s.grad is the sum over the axes of this matrix times d/d axis.
///
/// Source: Kajiya & Von Herzen 1984, section 4, which states these elements for unnormalised complex harmonics; its
/// printed element of z has its two fractions exchanged, a minus for a plus and 2 pi for the norm: a P1 system derived
/// from the printed element would contain no gradient. The basis here is orthonormal, which needs no norms.
std::vector<double> direction_coupling(int degree, int axis);

/// The truncation at degree 1, computed from the matrices of direction_coupling().
///
/// With phi = sqrt(4 pi) L_00 and F = sqrt(4 pi / 3) (L_11, L_1-1, L_10) the two lowest rows are
///     divergence * div F + sigma_t (1 - w0) phi = Q0
///     gradient * grad phi + sigma_t (1 - w0 g) F = Q1
/// so the diffusion coefficient is D = divergence * gradient / (sigma_t (1 - w0 g)).
struct P1Closure {
    double divergence;  ///< 1
    double gradient;    ///< 1/3
};
const P1Closure& p1_closure();

}  // namespace vdbcloud
