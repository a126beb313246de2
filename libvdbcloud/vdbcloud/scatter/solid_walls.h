#pragma once
// Solids as sweeps meet them: opaque voxels, and their surface as elements that are lit and send light back. Private to
// scatter/.
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/sweep/walls.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <vector>

namespace vdbcloud {

/// The surface of solids near a medium: one element where a line through the middles of voxels, along the index axis
/// that is nearest to the surface's normal, meets it; gaps of less than a voxel are passed over. Near: within `margin`
/// times the medium's longest edge of its box. Where that would be more elements than the medium has voxels, and than
/// `least_elements`, the margin is halved, and halved again.
struct SolidSurface {
    static constexpr double margin = 0.5;
    static constexpr size_t least_elements = size_t(1) << 16;

    /// Nothing without solids or voxels.
    SolidSurface(const FloatGrid& density, const SolidRays*);

    struct Element {
        Vec3d at;       ///< voxel coordinates of the density's tree
        Vec3d outside;  ///< [world], off the surface
        Vec3d normal;   ///< unit, outward [world]
        Vec3d along;    ///< the same, components along the index axes
        size_t solid;   ///< its number
    };
    std::vector<Element> elements;
    std::vector<Vec3i> blocks;  ///< VoxelIndexOptions::besides: those about the surface
};

/// What light of a channel depends on in the materials of solids, for ChannelInput::surfaces.
std::vector<double> reflectances(const std::vector<Solid>&, int channel);

/// The walls of the surface on the blocks of `index`. Inactive voxels whose centre lies within a solid are opaque.
SweepWalls walls_of(const SolidSurface&, const SolidRays&, const VoxelIndex& index);

/// One channel's light on the surface while sweeps find it: radiance = reflectance / pi (direct + irradiance).
struct LitWalls {
    WallLight light;
    std::vector<float> direct, reflectance;  ///< by element
    void reflect();
};

}  // namespace vdbcloud
