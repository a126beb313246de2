#pragma once
// Several media as one medium, for stages that solve for the light of all of them together.
#include "vdbcloud/optics/medium.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// One of the media that are joined.
struct MediumPart {
    std::string name;       ///< for messages: the file
    FloatGridPtr density;   ///< never null; may be empty
    Medium medium;          ///< sigma_t_per_density chosen
    Vec3SGridPtr colour;    ///< Cd: factor of the albedo, 1 outside its active voxels; may be null
    Vec3SGridPtr emission;  ///< radiance per world unit; may be null
};

/// A grid that was sampled on the lattice of another part.
struct ResampledPart {
    std::string name;
    double correction;  ///< factor that restored the optical mass; 1 - correction is the error of sampling
};

/// Of overlapping media (`parts`) density and medium serve as a description alone: what active voxels there are, and
/// how matter is distributed, by the mean of extinction over the channels. Albedo and phase function are of no part.
struct JoinedMedium {
    FloatGridPtr density;   ///< named as the density of the lead
    Medium medium;          ///< extinction and phase function of the lead
    Vec3SGridPtr colour;    ///< null where all parts have one albedo and no Cd
    Vec3SGridPtr emission;  ///< null where no part emits
    size_t lead = 0;        ///< number of the first part with a density above 0; 0 if there is none
    std::vector<ResampledPart> resampled;
    /// Media that keep their phase functions, albedos and extinctions, on the lattice of `density`; empty: one medium.
    std::vector<MediumPart> parts;
};

/// True if the density has an active value above 0.
bool has_matter(const FloatGrid& density);

/// The medium of all parts together. With k_n = sigma_t of part n over sigma_t of the lead, Cd clamped so that albedos
/// are within [0, 1], and all sums over parts,
///
///     density = sum k_n d_n,   albedo = sum k_n d_n albedo_n / density for each channel,   emission = sum e_n
///
/// so that extinction and scattering are those of all parts, voxel by voxel. Active where any part is. medium.albedo is
/// the greatest albedo of the parts, and Cd the albedo over that, at voxels of density above 0 and one voxel about
/// them.
///
/// Lattices: the finest one (least volume of a voxel). Parts whose voxels coincide with the lattice's, to 1e-4 of a
/// voxel, are copied: sums are exact to the rounding of a float, and tiles stay tiles. Other parts are sampled from
/// their trilinear interpolant, and density is scaled so that the optical mass of the part is kept. The interpolant of
/// the samples differs from the part's by O(voxel^2) of its curvature. Emission is joined by itself, on its own finest
/// lattice, and keeps its power. Cost: active voxels, leaves and tiles, wherever the parts lie.
///
/// Parts without density take part by their emission only. A part's phase function counts only if it scatters.
/// Errors: UsageError with both names for extinctions that are not proportional over the channels, for different phase
/// functions, and for lattices of which none is the finest along all axes. InputError for a transform that is not
/// affine.
///
/// `may_overlap`: media of different phase functions, or of extinctions that are not proportional, are not refused but
/// become JoinedMedium::parts.
JoinedMedium joined_medium(const std::vector<MediumPart>& parts, bool may_overlap = false);

}  // namespace vdbcloud
