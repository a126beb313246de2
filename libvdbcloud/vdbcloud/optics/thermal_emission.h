#pragma once
// Light of hot matter: the emission of a medium that has a temperature.
#include "vdbcloud/optics/medium.h"

namespace vdbcloud {

/// Where a medium is hot.
struct Fire {
    /// T [K] = offset + scale x value, trilinear between voxels; may be null: then of `flame`.
    FloatGridPtr temperature;
    double scale = 1, offset = 0;
    /// Luminous soot too thin to hide what is behind it: it emits and neither absorbs nor scatters. May be null.
    FloatGridPtr flame;
    /// Of `flame` at 1 [1/world unit]; below 0: the mean extinction of the medium at density 1.
    double flame_absorption = -1;
    double intensity = 1;  ///< factor of all emission; 1: that of a black body

    /// The grid that T comes from; null: there is no fire.
    const FloatGrid* heat() const { return temperature ? temperature.get() : flame.get(); }
    double kelvin(double value) const { return offset + scale * value; }
};

/// The greatest T of an active voxel [K]; 0 without a grid, or without active voxels.
double hottest(const Fire&);

/// The emission of a hot medium [radiance/world unit],
///
///     j = intensity (sigma_a + flame_absorption flame) B(T),   sigma_a = sigma_t_per_density density (1 - albedo Cd)
///
/// for each channel, B = blackbody() of scene/blackbody.h, Kirchhoff's law with the absorption of the medium: Planck's
/// radiance is then what an opaque medium shows, and S (1 - exp(-tau)) what one of albedo 0 and one temperature does.
/// `tint` is Cd; may be null, and is 1 outside its active voxels. The product is taken at the voxels of the density,
/// and of `flame` where density is 0, so that j is linear between them: exact for one temperature, and O(voxel^2) of
/// the curvature of B(T) elsewhere. Grids on other lattices are sampled there, trilinearly. Only voxels where j is
/// above 0 are active. A tile of density stays a tile where T, Cd and flame are one value there.
///
/// Null where the result is 0 everywhere. Cost: active voxels of density and flame that are hot. Threads: all of TBB's,
/// with equal results.
/// Throws InputError for a transform that is not affine.
Vec3SGridPtr thermal_emission(const FloatGrid& density, const Medium&, const Vec3SGrid* tint, const Fire&);

/// a + b, either of which may be null, on the finer lattice of the two. The power of each is kept.
Vec3SGridPtr sum_of_emission(const Vec3SGridPtr& a, const Vec3SGridPtr& b);

}  // namespace vdbcloud
