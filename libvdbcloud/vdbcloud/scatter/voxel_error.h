#pragma once
// What the size of the voxels does to collided light, measured by the same solve on coarser voxels.
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/scatter_plan.h"

namespace vdbcloud {

/// Differences are root mean squares of phi over the voxels of the coarser grid, weighted by density and relative to
/// the root mean square of phi so weighted; of three channels the worst. The light of a voxel of the coarser grid is
/// compared with the mean of the voxels in it, weighted by density: with what these scatter.
struct VoxelError {
    double twice = 0;  ///< between the solution and that on voxels of twice the edge
    double four = 0;   ///< between those on voxels of twice and four times the edge; 0: not solved
    double order = 1;  ///< of the error in the edge, log2(four / twice), within [1, 2]; 1 without `four`
    double error = 0;  ///< estimate of the solution's own error: twice / (2^order - 1)
};

/// Richardson's estimate of the error of `light`, which scatter_p1() made of these arguments, from two more solutions;
/// they take an eighth and a sixty-fourth of its time. The order is the measured one, for it depends on the medium:
/// near 2 where the medium is smooth over voxels and sweeps close P1, near 1 with sharp edges. Below 1, where coarser
/// voxels hide more and more, it says nothing of finer ones, and 1 is taken: the error is then what twice the edge
/// changed. 1 is taken, too, without a solution on four times the edge, which a periodic medium may not have. P1 alone
/// errs by about half of its estimate. A light that is 0 has no error.
///
/// What the density's own voxels lost of the cloud is not in it: the coarser densities are means of the one given.
///
/// Adds the events of the solutions to `work`. Errors as scatter_p1(): InputError where a periodic medium is no
/// multiple of 16 voxels.
VoxelError voxel_error(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
                       const std::vector<Light>& lights, const ScatterOptions& options, const CollidedLight& light,
                       const Progress& progress, Workload& work);

/// What voxel_error() would do and hold, but for the light.
ScatterPlan voxel_error_plan(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                             const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                             bool count);

}  // namespace vdbcloud
