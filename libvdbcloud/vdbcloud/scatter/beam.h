#pragma once
// The uncollided light of one lamp or sun as a source of P1, from the beam's power through each voxel face.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/voxels/brick_map.h"

#include <atomic>
#include <utility>
#include <vector>

namespace vdbcloud {

/// Density depth [density x world unit] from face centres to a light.
///
/// The depth of an exposed face is taken half a voxel further out, along the beam: the trilinear density reaches that
/// far. The power that this trilinear fringe removes from the beam is credited to the cell behind the face. The power
/// balance of the beam is then exact in a slab, and of second order on a cloud whose density falls to 0 at its edge. (A
/// step along the face's normal would move the point across the beam: a first-order error.)
struct BeamDepths {
    explicit BeamDepths(const Light& of) : light(of) {}

    Light light;  ///< a lamp on a plane of voxel faces stands beside the plane (beam_depths.cc)
    std::array<std::vector<float>, 3> lower;    ///< at the lower face of every active slot, by axis
    std::vector<std::array<float, 6>> exposed;  ///< at the exposed faces of exposed_voxels(), by Blocks::Face
    static constexpr int points = 4;            ///< of a face
    /// At points of exposed faces in a medium that is constant in each voxel, where voxels may be opaque
    /// (exposed_beam.h); -1: not computed. Empty: no voxel is opaque.
    std::vector<std::array<std::array<float, points>, 6>> boxed;
    /// By slot: 1 where a solid does not hide the light from the voxel's centre, else 0; such a voxel gets nothing of
    /// the beam. Empty: all see it.
    std::vector<uint8_t> seen;

    double sight(size_t slot) const { return seen.empty() ? 1.0 : double(seen[slot]); }
    /// Of a face between two voxels.
    double sight(size_t slot, size_t beside) const { return sight(slot) * sight(beside); }
};

/// Depths by one pass of the light lattice (sweep/) for a light of one direction, by one ray per face for any other
/// light. Of a light with a disc: from its centre (points_of() takes it apart). `density` is the trilinear medium,
/// `index` its voxels. `centres`, if given, gets centre_depths(). `products`: as of lattice_depths(). Threads:
/// parallel; values do not depend on the number of threads.
BeamDepths beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                       const Light& light, int rays_per_voxel = 2, std::vector<float>* centres = nullptr,
                       const Progress& progress = {}, std::atomic<size_t>* products = nullptr);

/// The sets of targets for which one pass of the lattice finds the depths of a light: centres, lower faces, and the
/// places beyond exposed faces of each kind. Offsets [voxels].
std::vector<Vec3d> beam_offsets(const VoxelIndex& index, const Vec3d& to_light, bool centres);

/// Depths in a medium that repeats along the periodic axes of `index`, by rays that wrap. Density is constant in each
/// voxel. Throws InputError if the light has more than one direction, or if its rays never leave the medium.
BeamDepths periodic_beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                                const std::vector<float>& density, const Light& light);

/// Density depth from one point (voxel coordinates of the blocks) to a light, in the medium of periodic_beam_depths().
/// The same errors.
double periodic_depth(const VoxelIndex& index, const std::vector<float>& density, const Light& light,
                      const Vec3d& point);

/// Depths at the centres of the active slots, for beam_fluence(): in the trilinear medium, and in a periodic one.
std::vector<float> centre_depths(const VoxelIndex& index, const BrickMap& density, const Light& light,
                                 int rays_per_voxel = 2);
std::vector<float> periodic_centre_depths(const VoxelIndex& index, const std::vector<float>& density,
                                          const Light& light);

/// Density depth [density x world unit] of parallel lines that cross the whole medium along a light of one direction,
/// and the area [world unit^2] per line. They measure the power that the light loses independently of voxel faces.
/// Density is constant in each voxel, as in the balance of the faces: a trilinear medium has more area across the light
/// where it has edges. There is one line for each voxel of a layer across the index axis that the light crosses
/// fastest, so the sum is exact along an axis. In a periodic medium the lines cover one period. Requires a light of one
/// direction.
struct LineDepths {
    std::vector<double> depth;  ///< above 0, if the medium is not periodic
    double area = 0;            ///< of one line
};
/// Cost: lines that meet a block of voxels, wherever the blocks lie; empty space is not visited.
LineDepths line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light);
LineDepths periodic_line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light);

/// Power that a beam of unit irradiance loses: area times the sum of (1 - exp(-extinction * depth)) over the lines.
double lost_power(const LineDepths&, double extinction);

/// Adds the collided source of a beam to one or more channels that share an operator. Each channel comes with the
/// strength of its light (Light::strength()).
///
/// U is the beam's power through a face: E T' s.n A, or for a lamp the exact solid angle x intensity x T'. The source
/// of a cell is Q0 V = w0' times the DIFFERENCE of U across the cell, which conserves energy at any sigma h. On a face,
/// Q1 / sigma_tr is w0' g' sigma_t' / sigma_tr U, averaged over its two cells by their resistance. On exposed faces Q1
/// enters the Marshak condition.
///
/// T' = exp(-extinction * depth), with `extinction` the scaled extinction at density 1 [1/world unit]. With a tint the
/// depths are those of the scaled density, and `extinction` is the unscaled extinction.
void add_beam(const P1Operator&, const BeamDepths&, double extinction,
              const std::vector<std::pair<P1Source*, double>>& channels);

/// Mean uncollided fluence of each cell at strength 1: the power that the cell removes from the beam, divided by
/// sigma_t' and the cell's volume. sigma_t' times this fluence is then the collision rate of P1's source at any
/// sigma h. Values are capped at the beam's fluence on the cell's brightest face.
std::vector<float> mean_fluence(const P1Operator&, const BeamDepths&, double extinction);

/// Uncollided fluence of each cell at strength 1 as the sweeps take it, linear from centre to centre.
///
/// Where voxels are optically thin it is U at the centre (by centre_depths()) divided by 1 + x^2 / 12, x = sigma_t' h:
/// the chord of an exponential from centre to centre has that much more area than the exponential. h is the root of the
/// sum of (s_a h_a)^2 over the axes, s the beam's direction and h_a the edges. Where voxels are
/// thick it is mean_fluence(). The weight is diffusive(x), of the medium alone. The cell of a lamp has its mean.
std::vector<float> beam_fluence(const P1Operator&, const BeamDepths&, const std::vector<float>& centre,
                                double extinction);

/// Correction of add_beam() in optically thick voxels, where the beam is scattered near the face that it enters by and
/// not in the middle. U falls exponentially from face to face, so the mean collided flux between two centres differs
/// from the value on the face. F gains (w0' + w0' g' sigma_t' / sigma_tr) (mean of U from centre to centre - U on the
/// face). The term is of second order in sigma h. Without this term a slab of 4 mean free paths a voxel transmits 1.6
/// times too much.
void add_beam_profile(const P1Operator&, const BeamDepths&, double extinction,
                      const std::vector<std::pair<P1Source*, double>>& channels);

}  // namespace vdbcloud
