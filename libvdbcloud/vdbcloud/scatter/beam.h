#pragma once
// The uncollided light of one lamp or sun as the source of P1: how much of it passes each face of each voxel.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/voxels/brick_map.h"

#include <utility>
#include <vector>

namespace vdbcloud {

/// Density depth [density x world unit] from face centres to a light.
///
/// The depth of an exposed face is taken half a voxel further out, along the beam: the trilinear density reaches that
/// far, and what it takes from the beam there belongs to the cell behind. In a slab the beam's power then balances
/// exactly; on a cloud whose density falls to 0 at its edge, to second order. (A step along the face's normal would
/// move the point across the beam, a first-order error.)
struct BeamDepths {
    explicit BeamDepths(const Light& of) : light(of) {}

    Light light;
    std::array<std::vector<float>, 3> lower;    ///< at the lower face of every active slot, by axis
    std::vector<std::array<float, 6>> exposed;  ///< at the exposed faces of exposed_voxels(), by Blocks::Face
};

/// By the lattice of sweep/ for a light of one direction (of a disc, its centre), else by a ray for each face.
/// `density` is the trilinear medium, index its voxels. Threads: parallel; values do not depend on how many.
BeamDepths beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                       const Light& light, int rays_per_voxel = 2, const Progress& progress = {});

/// The same in a medium that repeats along the index's periodic axes, constant in each voxel, by rays that wrap.
/// Lights of one direction only. Throws InputError if the light never leaves the medium.
BeamDepths periodic_beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                                const std::vector<float>& density, const Light& light);

/// Density depth of whole lines through the medium, with the area [world unit^2] each stands for, across a light of
/// one direction: the way to measure what the light loses without any voxel's face. For periodic media one period is
/// covered.
struct LineDepths {
    std::vector<double> depth;
    double area = 0;  ///< of one line
};
LineDepths line_depths(const VoxelIndex& index, const BrickMap& density, const Light& light);
LineDepths periodic_line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light);

/// Power that a beam of unit irradiance loses, the sum of (1 - exp(-extinction * depth)) over the lines.
double lost_power(const LineDepths&, double extinction);

/// Adds the collided source of a beam to one or more channels that share an operator, each with its light's
/// strength (Light::strength()).
///
/// With U the beam's power through a face, E T' s.n A (exact solid angle x intensity for a lamp), the source is
/// Q0 V = w0' times the DIFFERENCE of U across the cell, which keeps energy at any sigma h, and Q1 / sigma_tr on a face
/// is w0' g' sigma_t' / sigma_tr U, averaged over its two cells by their resistance; on exposed faces it enters the
/// Marshak condition. T' = exp(-extinction * depth), `extinction` the scaled one at density 1 [1/world unit]; with a
/// tint the depths are those of the scaled density, and `extinction` that at tint 1 without scaling.
void add_beam(const P1Operator&, const BeamDepths&, double extinction,
              const std::vector<std::pair<P1Source*, double>>& channels);

/// Mean fluence of the uncollided light in each cell at strength 1: what the cell takes from the
/// beam, divided by sigma_t' and the volume, so that sigma_t' times it is the collision rate that P1's source has, at
/// any sigma h; at most the beam's own at the cell's brightest face.
std::vector<float> beam_fluence(const P1Operator&, const BeamDepths&, double extinction);

/// What add_beam() leaves out where a voxel is thick: that the beam's light is scattered near the face it enters by,
/// not in the middle. With U falling exponentially from face to face the collided flux between two centres is not that
/// on the face, and F gains (w0' + w0' g' sigma_t' / sigma_tr) (mean of U from centre to centre - U on the face). Of
/// second order in sigma h; without it a slab of 4 mean free paths a voxel transmits 1.6 times too much.
void add_beam_profile(const P1Operator&, const BeamDepths&, double extinction,
                      const std::vector<std::pair<P1Source*, double>>& channels);

}  // namespace vdbcloud
