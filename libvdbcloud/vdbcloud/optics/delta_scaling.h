#pragma once
// Delta-M scaling: the medium in which the forward peak of scattering counts as unscattered.
#include "vdbcloud/optics/phase_function.h"

namespace vdbcloud {

/// Delta-M scaling at degree L. A share delta_f of the scattered light counts as a forward spike, that is, as
/// unscattered. With f = delta_f,
///
///     f = m_(L+1) if 0 < m_(L+1) <= m_l for all l <= L, else 0
///     m_l' = (m_l - f) / (1 - f),   w0' = w0 (1 - f) / (1 - w0 f),   sigma_t' = (1 - w0 f) sigma_t
///
/// with m_l the Legendre moments of the phase function. The scaled moments are then never negative. sigma_a and D are
/// unchanged, exactly. For Henyey-Greenstein delta_f = g^(L+1), and at L = 1 (delta-Eddington) m_1' = g / (1 + g).
///
/// A value type. All stages after the solve (light grids, series, picture) use one object, from the solver or a file.
/// Source: Joseph, Wiscombe & Weinman 1976; Wiscombe 1977.
struct DeltaScaling {
    int degree = 1;                     ///< L, degree of the scattering expansion of collided light
    double delta_f = 0;                 ///< in [0, 1)
    std::vector<double> moments{1, 0};  ///< m_l', l = 0 .. degree

    double mean_cosine() const { return moments[1]; }  ///< g' = m_1'
    /// The highest degree with a nonzero scaled moment: scattering needs no harmonics of higher degree.
    int last_degree() const;
    double albedo(double w0) const { return w0 * (1 - delta_f) / (1 - w0 * delta_f); }  ///< w0'
    double extinction(double w0) const { return 1 - w0 * delta_f; }                     ///< sigma_t' / sigma_t
    double scattering() const { return 1 - delta_f; }                                   ///< w0' sigma_t' / (w0 sigma_t)
};

/// Throws InputError unless degree >= 1.
DeltaScaling delta_scaling(const PhaseFunction&, int degree);
/// Expansion of the same degree without scaling: delta_f = 0. Throws InputError unless degree >= 1.
DeltaScaling no_scaling(const PhaseFunction&, int degree);
/// Of scalings of one degree: for each degree the moment that is farthest from 0, and delta_f 0. last_degree() is then
/// that of all of them.
DeltaScaling largest_of(const std::vector<DeltaScaling>&);

/// Writes the metadata of a grid of collided light: degree, delta_f and the scaled moments (grid/scatter_schema.h).
void write_delta_scaling(MetaMap&, const DeltaScaling&);
/// Reads the metadata of write_delta_scaling(). Without scaled moments, they are computed from `phase` with the file's
/// degree and delta_f. Without degree and delta_f, light is unscaled at degree 1. Throws InputError that names the
/// invalid key.
DeltaScaling read_delta_scaling(const MetaMap&, const PhaseFunction& phase);

}  // namespace vdbcloud
