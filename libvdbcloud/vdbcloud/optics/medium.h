#pragma once
// The coefficients of a medium, stored in a file as metadata of the density grid.
#include "vdbcloud/optics/phase_function.h"

namespace vdbcloud {

/// A medium whose extinction is proportional to a density grid, per colour channel r, g, b.
struct Medium {
    Vec3d sigma_t_per_density{0, 0, 0};  ///< [1/world unit] at density 1; all 0: unset
    Vec3d albedo{1, 1, 1};               ///< sigma_s / sigma_t, in [0, 1]
    PhaseFunction phase{"henyey-greenstein"};

    bool grey() const;  ///< true if the three channels share one extinction
};

/// Reads the coefficients that metadata gives; all others are copied from `otherwise`. A missing parameter of the phase
/// function is copied from `otherwise` if both phase functions have the same form, else it has its default.
/// Throws InputError that names the invalid key: extinction below 0 or not finite, albedo outside [0, 1], an unknown
/// phase function, or a parameter that is missing or out of range.
Medium read_medium(const MetaMap&, const Medium& otherwise = {});
/// Reads the phase function only, by the rules of read_medium().
PhaseFunction read_phase(const MetaMap&, const PhaseFunction& otherwise);
/// Writes the coefficients and removes parameters of other phase functions. Throws as read_medium() does; the
/// metadata are then unchanged.
void write_medium(MetaMap&, const Medium&);

}  // namespace vdbcloud
