#pragma once
// Delta-M scaling: the medium in which the forward peak of scattering counts as unscattered.
#include "vdbcloud/optics/phase_function.h"

namespace vdbcloud {

/// Delta-M scaling at degree L. The share f of scattered light is taken as a forward spike, that is as not scattered:
///
///     f = m_(L+1) if 0 < m_(L+1) <= m_l for all l <= L, else 0
///     m_l' = (m_l - f) / (1 - f),   w0' = w0 (1 - f) / (1 - w0 f),   sigma_t' = (1 - w0 f) sigma_t
///
/// with m_l the Legendre moments of the phase function. The scaled moments are then never negative. sigma_a and D are
/// unchanged, exactly. For Henyey-Greenstein f = g^(L+1), and at L = 1 (delta-Eddington) m_1' = g / (1 + g).
///
/// A value type. Everything behind the solve (light grids, series, picture) takes it whole, from the solver or from a
/// file.
/// Source: Joseph, Wiscombe & Weinman 1976; Wiscombe 1977.
struct DeltaScaling {
    int degree = 1;                     ///< L, of the expansion that collided light is scattered with
    double f = 0;                       ///< in [0, 1)
    std::vector<double> moments{1, 0};  ///< m_l', l = 0 .. degree

    double mean_cosine() const { return moments[1]; }  ///< g' = m_1'
    /// The last degree whose scaled moment is not 0: scattering needs no harmonics above it.
    int last_degree() const;
    double albedo(double w0) const { return w0 * (1 - f) / (1 - w0 * f); }  ///< w0'
    double extinction(double w0) const { return 1 - w0 * f; }               ///< sigma_t' / sigma_t
    double scattering() const { return 1 - f; }                             ///< w0' sigma_t' / (w0 sigma_t)
};

/// Throws InputError unless degree >= 1.
DeltaScaling delta_scaling(const PhaseFunction&, int degree);
/// The same expansion unscaled: f = 0.
DeltaScaling no_scaling(const PhaseFunction&, int degree);

/// As metadata of a grid of collided light: degree, delta_f and the scaled moments (grid/scatter_schema.h).
void write_delta_scaling(MetaMap&, const DeltaScaling&);
/// What write_delta_scaling() wrote. A file without scaled moments has those of `phase` with its degree and f; one
/// without degree and f is taken as unscaled at degree 1. Throws InputError naming the key whose value cannot be.
DeltaScaling read_delta_scaling(const MetaMap&, const PhaseFunction& phase);

}  // namespace vdbcloud
