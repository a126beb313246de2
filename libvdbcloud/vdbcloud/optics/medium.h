#pragma once
// The coefficients of a medium, and how they travel in a file: as metadata of its density grid.
#include "vdbcloud/optics/phase_function.h"

namespace vdbcloud {

/// A medium whose extinction is proportional to a density grid, per colour channel r, g, b.
struct Medium {
    Vec3d sigma_t_per_density{0, 0, 0};  ///< [1/world unit] at density 1; all 0: not chosen yet
    Vec3d albedo{1, 1, 1};               ///< sigma_s / sigma_t, in [0, 1]
    PhaseFunction phase{"henyey-greenstein"};

    bool grey() const;  ///< the three channels share one extinction
};

/// Reads what metadata gives and takes everything else from `otherwise`. A parameter of the phase function that
/// metadata lacks is that of `otherwise` if that is of the same form, else its default.
/// Throws InputError naming the key whose value cannot be: extinction below 0 or not finite, albedo outside [0, 1], an
/// unknown phase function, a parameter that is missing or out of range.
Medium read_medium(const MetaMap&, const Medium& otherwise = {});
/// The phase function alone, likewise.
PhaseFunction read_phase(const MetaMap&, const PhaseFunction& otherwise);
/// Writes the coefficients and removes parameters of other phase functions. Throws as read_medium() does, before it
/// writes anything.
void write_medium(MetaMap&, const Medium&);

}  // namespace vdbcloud
