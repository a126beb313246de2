#pragma once
// What reaches the exposed faces of opaque voxels. Private to scatter/.
#include "vdbcloud/scatter/beam.h"

namespace vdbcloud {

/// Completes BeamDepths::boxed for the exposed voxels that may be opaque at `extinction` [1/world unit at density 1],
/// under any delta scaling. In a periodic medium there are none: its depths are those of constant voxels. Threads:
/// parallel; values do not depend on their number. Cost: four rays a face; a ray visits the voxels that it meets, and
/// empty space in some dozens of steps.
void add_boxed_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                      const std::vector<float>& density, double extinction, BeamDepths& depths);
/// As that, of the medium of `p1`: its density, scaled where the albedo changes from voxel to voxel.
void add_boxed_depths(const P1Operator& p1, BeamDepths& depths);

/// The density depths from exposed faces to a light, with weights of sum 1.
///
/// In a trilinear medium an opaque voxel darkens half a voxel of emptiness on every side of it, for the faces of other
/// voxels and, under slanting light, for its own: a box of voxels of 10 mean free paths lost a quarter of the light
/// that falls on it, a diagonal line of voxels of 100 three quarters. In P1's cells the faces of the voxels bound the
/// medium. So where voxels are opaque the depth is that of constant voxels, the mean of T' over four points of a face.
/// Its weight is 1 - 1 / (2 x)^2, 0 for x <= 1/2, x the mean free paths of the voxel along the beam (width_along()).
class ExposedBeam {
public:
    /// Keeps references. `extinction`: as of add_beam().
    ExposedBeam(const P1Operator& p1, const BeamDepths& depths, double extinction);

    /// Calls f(weight, depth) for an exposed face of p1.exposed()[k].
    template<typename F>
    void each_depth(size_t k, int face, const F& f) const
    {
        const double boxed = weight_.empty() ? 0.0 : double(weight_[k]);
        if (boxed < 1) f(1 - boxed, double(depths_.exposed[k][size_t(face)]));
        for (int n = 0; n < BeamDepths::points && boxed > 0; ++n)
            f(boxed / BeamDepths::points, double(depths_.boxed[k][size_t(face)][size_t(n)]));
    }
    /// T' of an exposed face, and T' - 1 to its own rounding.
    struct Transmitted {
        double part, less;
    };
    Transmitted operator()(size_t k, int face) const;

private:
    const BeamDepths& depths_;
    double extinction_;
    std::vector<float> weight_;  // of BeamDepths::boxed; empty: 0
};

/// Root of the sum of squares of what a direction (unit, world) crosses of a voxel's edges: h for cubes. A field that
/// is linear from centre to centre of an exponential along the direction is too large by (sigma_t' times this)^2 / 12.
double width_along(const VoxelIndex& index, const Vec3d& direction);

}  // namespace vdbcloud
