#pragma once
// What a scaled picture of single scattering misses near the sun: light scattered more than once within the forward
// peak.
#include <vector>

namespace vdbcloud {

/// A delta-scaled picture takes single scattering by the true Henyey-Greenstein phase function, attenuated by the
/// scaled medium (TMS). That is right to first order in what scattering adds to the moments above the degree L of the
/// scaling, f = g^(L+1). Scattered ever again by small angles, along a path of w0 tau = x, moment l of the beam is
/// exp(x (g^l - f)) times the scaled beam's, and what TMS has of it is x (g^l - f). The ratio of the two sums over l >
/// L, the part up to L being the solver's, is
///
///     R(angle, x) = 1 + sum over l > L of (2l+1) P_l (e^u - 1 - u) / (x 4 pi p),    u = x (g^l - f)
///
/// by which single scattering is multiplied. At 20 degrees from a sun behind x = 8, g = 0.85, it is 0.31 at degree 1,
/// 0.74 at degree 3 and 1.20 at degree 7. Small angles are what it is about: it fades to 1 between 45 and 75 degrees.
///
/// A table, bilinear in the root of the angle and the logarithm of 1 + x; x beyond 64 counts as 64. Immutable.
/// Source: Nakajima & Tanaka 1988, whose second-order correction (IMS) is u^2 / 2 of e^u - 1 - u.
class ForwardPeak {
public:
    /// Henyey-Greenstein g in (0, 1), f = g^(degree+1).
    ForwardPeak(double g, int degree);
    double operator()(double cosine, double x) const;

private:
    double exact(double cosine, double x) const;
    double g_, f_;
    int degree_;
    std::vector<float> table_;
};

}  // namespace vdbcloud
