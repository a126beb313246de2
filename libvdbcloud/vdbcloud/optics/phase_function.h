#pragma once
// Phase functions: how scattered light is spread over directions.
#include "vdbcloud/optics/medium.h"

namespace vdbcloud {

/// p(cos_theta) [1/sr], normalised: its integral over the sphere is 1.
///
/// Directions point along propagation and cos_theta = dot(w_in, w_out), so scattering straight on is +1:
///
///     isotropic            1 / (4 pi)
///     Rayleigh             3 / (16 pi) (1 + cos^2)
///     Henyey-Greenstein    (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2))
///
/// Texts whose two vectors both point away from the scatterer write + 2 g cos; ours have the opposite sign of
/// cos.
///
/// A value type: copy it freely, share it between threads.
/// Source: Kajiya & Von Herzen 1984, section 2 (phase functions); Henyey & Greenstein 1941.
class PhaseFunction {
public:
    /// g is the mean cosine of Henyey-Greenstein and is passed over by the others. Throws InputError unless
    /// |g| < 1.
    explicit PhaseFunction(PhaseKind kind = PhaseKind::Isotropic, double g = 0);
    explicit PhaseFunction(const Medium& medium) : PhaseFunction(medium.phase, medium.g) {}

    double operator()(double cos_theta) const;

    /// The mean of cos_theta under p: g, or 0 for the symmetric ones.
    double mean_cosine() const { return moment(1); }

    /// The l-th Legendre moment, 2 pi int_-1^1 p(c) P_l(c) dc, l >= 0: 1, then g, ... (Henyey-Greenstein:
    /// g^l; Rayleigh: 1, 0, 1/10, 0, ...). It is the eigenvalue of the scattering operator on harmonics of
    /// degree l.
    double moment(int l) const;

private:
    PhaseKind kind_;
    double g_;
};

}  // namespace vdbcloud
