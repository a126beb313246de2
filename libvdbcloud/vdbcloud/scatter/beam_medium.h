#pragma once
// The medium of one channel as beams see it: scaled extinction, trilinear or periodic. Private to scatter/.
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/scatter/beam.h"

#include <optional>

namespace vdbcloud {

/// Scaled extinction at density 1 [1/world unit], the factor of beam depths of the density; the unscaled one where the
/// albedo changes from voxel to voxel.
double beam_extinction(const P1Operator&);

/// What the density depths of all lights of a channel are taken from.
///
/// The medium is the trilinear density or, where the albedo changes from voxel to voxel, the density times sigma_t' /
/// sigma_t. A periodic medium is constant in each voxel.
class BeamMedium {
public:
    /// Keeps references to `index` and to the density of the operator. `grid`: the voxels, and of one medium its
    /// density. `solids`, if given, hide lights: BeamDepths::seen, and depth().
    BeamMedium(const VoxelIndex& index, const FloatGrid& grid, const P1Operator&, const SolidRays* solids = nullptr);

    double extinction() const { return extinction_; }  ///< sigma_t' at density 1 [1/world unit]
    /// The trilinear density of which extinction() is the factor; null for a periodic medium.
    const BrickMap* bricks() const { return bricks_ ? &*bricks_ : nullptr; }

    /// `centres`, if given, gets the depths at the centres of the active slots, for beam_fluence(). `products`: as of
    /// lattice_depths().
    BeamDepths depths(const std::vector<ExposedVoxel>&, const Light&, int rays_per_voxel, std::vector<float>* centres,
                      const Progress&, std::atomic<size_t>* products = nullptr) const;
    /// Depths of lines, for lost_power(). Requires a light of one direction.
    LineDepths lines(const Light&) const;
    /// Density depth from a point (voxel coordinates) to a light; infinity where a solid hides it.
    double depth(const Vec3d& voxel, const Light&) const;
    /// The same from a point in world space, of a medium that ends on all sides.
    double depth_from(const Vec3d& x, const Light&) const;

private:
    const VoxelIndex& index_;
    const std::vector<float>& density_;
    double extinction_;
    std::vector<float> scaled_;  // density of a periodic medium, if not density_
    bool hidden(const Vec3d& x, const Light&) const;
    const SolidRays* solids_;
    std::optional<BrickMap> bricks_;  // of a medium that ends on all sides
    const std::vector<float>& values() const { return scaled_.empty() ? density_ : scaled_; }
};

}  // namespace vdbcloud
