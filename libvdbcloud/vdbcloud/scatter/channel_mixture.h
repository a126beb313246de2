#pragma once
// Overlapping media as one medium of one colour channel, voxel by voxel. Private to scatter/.
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud {

/// With k_n the extinction of part n at density 1 over sigma_t, and sums over parts at a voxel:
///
///     density = sum k_n d_n,   albedo = sum k_n d_n w0_n / density,   share_n = k_n d_n w0_n / sum of these
///
/// so that extinction, scattering and each Legendre moment of what is scattered are those of all parts.
struct ChannelMixture {
    double sigma_t = 1;          ///< at density 1 [1/world unit]: the greatest of the parts
    double albedo = 1;           ///< the greatest of the parts
    std::vector<float> density;  ///< by slot
    std::vector<float> tint;     ///< the albedo at the slots over `albedo`; empty: 1 everywhere
    MixedPhases phases;

    bool operator==(const ChannelMixture&) const;
};

/// Parts share one lattice, that of `index`.
ChannelMixture channel_mixture(const VoxelIndex& index, const std::vector<MediumPart>& parts, int channel);

}  // namespace vdbcloud
