#pragma once
// Radiance along many directions through the active voxels of a cloud: the transport equation with a known source.
#include "vdbcloud/sweep/ground_patch.h"
#include "vdbcloud/sweep/plane_light.h"
#include "vdbcloud/sweep/walls.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <memory>
#include <optional>
#include <vector>

namespace vdbcloud {

class PeriodicSweep;

/// The directions of a quadrature and the functions of direction that source and result are expanded in.
struct SweepSet {
    std::vector<Vec3d> direction;  ///< unit, components along index.axis(0..2), the way light travels
    std::vector<float> weight;     ///< [sr]
    int source_terms = 0;
    std::vector<float> source_basis;  ///< direction by direction, source_terms each
    int moment_terms = 0;
    std::vector<float> moment_basis;  ///< direction by direction, moment_terms each, without the weight
    std::vector<float> inflow;        ///< the sky's radiance along each direction; empty: dark

    size_t count() const { return direction.size(); }
};

/// A face of an active voxel to one that is not: `face` as Blocks::Face.
struct SweepFace {
    uint32_t slot;
    uint8_t face;
};

/// Integrals of L over all directions on a face with outward normal n.
struct FaceTally {
    float current = 0;  ///< int s.n L
    float fluence = 0;  ///< int L
    float second = 0;   ///< int ((s.n)^2 - 1/3) L
};

/// The fields of a sweep: one value for each slot of the index's blocks, 0 at inactive slots.
struct SweepFields {
    const std::vector<float>* sigma_t = nullptr;              ///< [1/world unit]
    const std::vector<std::vector<float>>* source = nullptr;  ///< S / sigma_t, source_terms arrays [radiance]
    /// S is emission: S itself is linear from voxel to voxel, as in pictures. Else S / sigma_t is, as scattered light
    /// is.
    bool emission = false;
};

/// A Lambertian ground beneath a medium. Directions that go down are swept before the others, and the radiance of the
/// others begins with albedo (direct + E) / pi on the ground: no iteration is needed for light that the ground
/// reflects.
///
/// Under a medium that repeats along both axes across `face` the cells are those of that plane of the ActiveBox. Under
/// a medium that ends on all sides they are those of `patch`, and all values are changes by the medium: the radiance of
/// the endless ground without the medium is that of SweepSet::inflow along directions that go up.
struct SweepGround {
    int face = 0;  ///< Blocks::Face
    double albedo = 0;
    std::vector<float> direct;         ///< irradiance of each cell that does not come by the sweep
    std::optional<GroundPatch> patch;  ///< under a medium that ends on all sides
    /// Result: E of each cell, the sum over the directions that leave of weight x s.n x L, times pi over
    /// PlaneLight::of_unit_radiance. On a patch L is that at the middle of the cell, less the sky's.
    std::vector<float> irradiance;
};

struct SweepResult {
    /// moment_terms arrays over the slots: sum over directions of weight x basis x L.
    std::vector<std::vector<float>> moments;
    std::vector<FaceTally> tally;  ///< of each face asked for
};

/// What channels of one extinction have of their own in a sweep: sources, sky, results.
struct SweepChannel {
    const SweepSet* set = nullptr;  ///< equal for all channels but for `inflow`
    const std::vector<std::vector<float>>* source = nullptr;
    SweepResult* result = nullptr;
    PlaneLight* planes = nullptr;   ///< null: not asked for
    SweepGround* ground = nullptr;  ///< of all channels or of none; equal but for `direct`
    WallLight* walls = nullptr;     ///< of all channels or of none; of the same walls
};

/// Solves s.grad L + sigma_t L = S for each direction, by short characteristics.
///
/// L lives at voxel centres; at those of opaque voxels (walls.h) it is the walls'. A voxel's characteristic is followed
/// back to the plane of centres before it, across the axis along which the direction crosses most voxels (along a
/// diagonal, any of these axes gives the same). There L, sigma_t and S are interpolated bilinearly from four voxels;
/// from there on sigma_t and q = S / sigma_t are linear in length, as a picture's rays see them:
///
///     tau = (sigma_u + sigma) ds / 2,   L = L_u e^-tau + q (1 - e^-tau) + (q_u - q) w,
///     w = (1 - e^-tau) / tau - e^-tau - (sigma - sigma_u) ds / (12 + 6 tau + 2 tau^2)
///
/// The first two terms of w are exact for uniform sigma_t. The last is how the emission leans with sigma_t: first
/// order in its change, second in tau, and of the right size at large tau. Weights are >= 0 and sum to 1: L is a mean
/// of inflow and q, so a furnace is kept to rounding and nothing is negative. q_u is S_u / sigma_u; where one of the
/// two ends is void q is that of the other. Of SweepFields::emission S is linear in length, and
///
///     w = sigma_u / (sigma_u + sigma) (1 - e^-tau) 2 (1/x - 1 / (e^x - 1)),   x = sigma ds
///
/// exact for uniform sigma_t and for small tau; within 2 % of 1 - e^-tau up to tau = 8, 10 % at 20, 24 % at 60. By the
/// w above a voxel that emits beside one without extinction would lose a third of its half of the light between them.
/// Bilinear interpolation from plane to plane spreads a beam: first order in the voxel. The scheme is not conservative;
/// whoever needs balance takes ratios from it (scatter/second_moment.h). Voxels that are not active have sigma_t = 0;
/// inside blocks light crosses them the same way, outside blocks by rays (void_rays.h) that end at a block's face or in
/// the sky. Light that leaves a block into the void has crossed the half voxel about its last centres.
///
/// On faces L is that of the middle: taken where light passed the plane of centres half a voxel before, at most one
/// voxel aside, from the four about it; outward, of the voxel's own plane and after half a voxel of it. (From the
/// voxel's own centre alone the corners of a staircase would shine twice: 5 to 30 % too much power at half a mean free
/// path a voxel.) On faces that a direction runs along, the voxel's own.
///
/// Cost: time proportional to blocks x directions, but for PlaneLight::by_cell. Moments and source are in single
/// precision. Threads: blocks that do not depend on one another in parallel; values do not depend on their number.
/// Source: Kunasz & Auer 1988 (short characteristics with linear interpolation); Kajiya & Von Herzen 1984, section 4,
/// is the equation.
class TransportSweep {
public:
    /// Keeps a reference to `index`. `faces` are sorted by slot. Throws InputError for a medium that repeats along all
    /// axes.
    TransportSweep(const VoxelIndex& index, std::vector<SweepFace> faces);
    ~TransportSweep();

    /// `result` is overwritten; its arrays are kept if they fit. `planes`, if given, is the light through the planes of
    /// the box about the voxels; PlaneLight::by_cell is a request. A plane that cuts a block takes light as a face
    /// does. Other light comes by rays from the faces of blocks. `ground`: as for reference_sweep(). Throws InputError
    /// if the medium repeats and the ground is a patch, or if it ends on all sides and the ground is none; for a ground
    /// under a medium that repeats along one axis; for walls in one that repeats; and for a direction along periodic
    /// axes only.
    void run(const SweepSet&, const SweepFields&, SweepResult& result, PlaneLight* planes = nullptr,
             SweepGround* ground = nullptr, WallLight* walls = nullptr);
    /// The same for channels of one extinction, three at a time: attenuation and the ways through the void are computed
    /// once. The values of each are, bit by bit, those of a run of its own.
    void run(const std::vector<float>& sigma_t, bool emission, const std::vector<SweepChannel>&);

    /// Bytes of the last run, source and moments not included.
    size_t bytes() const;

private:
    struct Impl;
    void check(const SweepChannel&) const;
    std::unique_ptr<Impl> impl_;
    std::unique_ptr<PeriodicSweep> periodic_;  // instead, for a medium that repeats
};

/// The definition of TransportSweep: voxel by voxel in double precision, slow, serial in a direction.
///
/// Takes periodic axes as well, as long as one axis is not. Planes then lie across an axis that is not periodic, so a
/// characteristic may cross many voxels from plane to plane; extinction stays linear in length, exact for layers.
/// Throws InputError for a direction along periodic axes only.
///
/// `ground`, if given, is what rays that come from beneath the plane meet. They meet the ground at the plane of centres
/// beyond the outermost voxels, where the trilinear medium ends, and interpolate its cells bilinearly. A patch adds to
/// the inflow of these rays.
void reference_sweep(const VoxelIndex& index, const std::vector<SweepFace>& faces, const SweepSet&, const SweepFields&,
                     SweepResult& result, PlaneLight* planes = nullptr, SweepGround* ground = nullptr,
                     WallLight* walls = nullptr);

}  // namespace vdbcloud
