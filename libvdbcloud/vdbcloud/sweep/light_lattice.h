#pragma once
// Optical depth from a directional light at every target voxel, in time proportional to the voxels.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/voxels/brick_map.h"

#include <atomic>
#include <vector>

namespace vdbcloud {

struct LatticeOptions {
    int rays_per_voxel = 2;  ///< along each axis across the light, >= 1
    Vec3d offset{0, 0, 0};   ///< targets lie at voxel centre + offset [voxels]: (.5,0,0) for faces
    int refine = 1;          ///< targets a voxel along each axis: target n lies at voxel n / refine, >= 1
    std::atomic<size_t>* products = nullptr;  ///< counts values of voxels added to rays; null: not
};

/// Targets at voxel centre + offset [voxels] of blocks of 8^3 voxels.
struct LatticeTargets {
    Vec3d offset;
    std::vector<Vec3i> blocks;  ///< block b holds the targets of voxels 8b..8b+7
};

/// The density depth from each target point towards a light at infinity:
///
///     depth(x) = \int_0^infinity rho(x + t to_light) dt      [density x world unit]
///
/// Persistent rays on a lattice aligned with the light run through the medium from plane to plane of voxels.
/// All rays of one lattice phase cross cell walls at the same distances, so the exact integral of the trilinear density
/// over one plane step is one fixed stencil for the whole plane. Targets interpolate bilinearly, once, between the four
/// rays about them: that is the method's only error, O((1/rays_per_voxel)^2), as nothing is interpolated from plane to
/// plane. A plane-to-plane sweep of the voxels themselves would smear every shadow's edge.
///
/// Planes lie across the index axis along which light crosses most voxels. Along a diagonal there are two or three such
/// axes: the depth is the mean over them, so that the axes' order does not count. Such lights cost two or three times
/// as much.
///
/// `to_light`: unit, world space. Returned are 512 depths for each block of each set, the target of voxel (x,y,z) of it
/// at (x*8 + y)*8 + z, the layout of an OpenVDB leaf. All sets are found by one pass of rays, which stop wherever a set
/// has targets: a set more costs its targets and, between two planes, a stop. Cost: targets + voxels other than 0,
/// wherever they lie; empty space is not visited. Rays are summed in single precision within a step (lattice_tile.h):
/// transmittance errs by less than 1e-6.
/// Threads: tiles of rays in parallel; the value of a target does not depend on how many.
/// Source: Kajiya & Von Herzen 1984, section 3.1, pass one.
std::vector<std::vector<float>> lattice_depths(const BrickMap& density, const Vec3d& to_light,
                                               const std::vector<LatticeTargets>& sets, int rays_per_voxel,
                                               const Progress& progress = {}, std::atomic<size_t>* products = nullptr);

/// As above for one set of targets. With `refine` block b holds the targets 8b..8b+7; offsets apply without it only.
std::vector<float> lattice_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& blocks,
                                  const LatticeOptions& options, const Progress& progress = {});

/// The products that lattice_depths() would count for sets at these offsets, within some per cent and for a small part
/// of the time: each plane's values other than 0 times the mean number of taps. Targets do not matter.
size_t lattice_products(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3d>& offsets,
                        int rays_per_voxel);

/// The offsets within a voxel of targets refined by `refine`.
std::vector<Vec3d> refined_offsets(int refine);

}  // namespace vdbcloud
