#pragma once
// Correction of delta-scaled single scattering near a light for repeated scattering by the forward peak. Private to
// render/.
#include "vdbcloud/optics/delta_scaling.h"

#include <vector>

namespace vdbcloud {

/// A delta-scaled picture takes single scattering by the true phase function p, attenuated by the scaled medium (TMS).
/// TMS is correct to first order in the moments above the degree L of the scaling. Along a path of w0 tau = x, any
/// number of small-angle scatterings multiplies moment l of the scaled beam by exp(x (m_l - f)). Of this factor TMS
/// includes only the term x (m_l - f). Moments up to L belong to the solver. The ratio of the two sums over l > L is
///
///     R(angle, x) = 1 + sum over l > L of (2l+1) P_l (e^u - 1 - u) / (x 4 pi p),    u = x (m_l - f)
///
/// by which single scattering is multiplied. At 20 degrees from a sun behind x = 8, for Henyey-Greenstein of g = 0.85,
/// R is 0.31 at degree 1, 0.74 at degree 3 and 1.20 at degree 7. R holds for small angles and is faded to 1 between 45
/// and 75 degrees.
///
/// Stored as a table, bilinear in the root of the angle and the logarithm of 1 + x; x is capped at 64. Immutable.
/// Construction takes less than 0.1 s for any phase function: the sum over l ends some hundreds of sign changes of P_l
/// out, and its summands are linear between degrees 1/256 apart. Source: Nakajima & Tanaka 1988, whose second-order
/// correction (IMS) is the term u^2 / 2 of e^u - 1 - u.
class ForwardPeak {
public:
    /// `scaling` is the delta scaling of `phase`, with f > 0.
    ForwardPeak(const PhaseFunction& phase, const DeltaScaling& scaling);
    double operator()(double cosine, double x) const;

    static constexpr double deepest = 64;
    static constexpr double log_of_deepest = 4.1743872698956368;  ///< log(1 + deepest)
    static constexpr int depths = 64;
    /// R at one angle: entry j for log(1 + x) = j log_of_deepest / (depths - 1), linear between, constant from
    /// `deepest` on. Empty where R is 1.
    std::vector<double> at_angle(double cosine) const;

private:
    std::vector<float> table_;
};

}  // namespace vdbcloud
