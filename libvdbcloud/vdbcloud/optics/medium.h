#pragma once
// The coefficients of a medium, and how they travel in a file: as metadata of its density grid.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud {

enum class PhaseKind { Isotropic, Rayleigh, HenyeyGreenstein };

/// A medium whose extinction is proportional to a density grid, per colour channel r, g, b.
struct Medium {
    Vec3d sigma_t_per_density{0, 0, 0};  ///< [1/world unit] at density 1; all 0: not chosen yet
    Vec3d albedo{1, 1, 1};               ///< sigma_s / sigma_t, in [0, 1]
    double g = 0;                        ///< mean cosine, in (-1, 1)
    PhaseKind phase = PhaseKind::HenyeyGreenstein;

    bool grey() const;  ///< the three channels share one extinction
};

const char* name(PhaseKind);
PhaseKind phase_kind(const std::string& name);  ///< Throws InputError with the names that there are.

/// Reads what metadata gives and leaves the rest as it is in `otherwise`.
/// Throws InputError naming the key whose value cannot be: extinction below 0 or not finite, albedo outside
/// [0, 1], g outside (-1, 1), a phase function that is not known. So does write_medium, before it writes
/// anything.
Medium read_medium(const MetaMap&, const Medium& otherwise = {});
void write_medium(MetaMap&, const Medium&);

}  // namespace vdbcloud
