#pragma once
// Private to scatter/. Light of a sun that is scattered for the first time, on a set of directions.
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/scatter/ordinates.h"

#include <vector>

namespace vdbcloud {

/// The scaled phase function of light that travels along `along` (unit), at each direction s_m of `set` [1/sr].
///
/// The expansion that delta scaling leaves ends at its degree, so it rings: at g = 0.85 and degree 7 it is ten times
/// the phase function p at right angles, of either sign. Light that a thin medium scatters back is made of that. Here
///
///     x_m = T_m + T_m^3 sum over l <= L, m' of a_lm' Y_lm'(s_m),   T_m = min(p(s_m . along) / (1 - delta_f), peak)
///
/// with the a_lm' for which the set's moments of x up to the degree L of `scaling` are those of the expansion, and the
/// expansion's peak sum of (2 l + 1) / (4 pi) |m_l'|: what p has above it, scaling counts as not scattered. Among all
/// values with these moments x has the least sum of w_m (x_m - T_m)^2 / T_m^3: power, mean cosine and what else the
/// expansion carries are kept, values at large angles are the phase function's, and what is cut comes from the peak.
/// The power 3 is by measurement, of slabs and clouds at degrees 1 to 7: with 1.5 too much is cut far from the peak and
/// made up for behind (a slab of optical depth 1 reflects 25 % too much at degree 1, with 3 it is 19 %); above 3
/// radiance comes back to the expansion's. x equals the expansion where that is complete (isotropic; Rayleigh from
/// degree 2 on). Close to the peak x may be negative.
///
/// `set` must have at least the degree of `scaling`. Source: to fit outside the peak is Hu et al. 2000 (delta-fit); the
/// fit on ordinates that keeps all moments has none.
std::vector<double> first_scattering(const Ordinates& set, const PhaseFunction&, const DeltaScaling& scaling,
                                     const Vec3d& along);

/// The expansion itself: sum over l <= L of (2 l + 1) / (4 pi) m_l' P_l(s_m . along).
std::vector<double> expanded_scattering(const Ordinates& set, const DeltaScaling& scaling, const Vec3d& along);

}  // namespace vdbcloud
