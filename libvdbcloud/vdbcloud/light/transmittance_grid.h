#pragma once
// Pass one: the light that reaches each voxel, as a transmittance grid for each light.
#include "vdbcloud/core/effects.h"
#include "vdbcloud/core/progress.h"
#include "vdbcloud/core/workload.h"
#include "vdbcloud/grid/accuracy.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/solid.h"

#include <array>
#include <cstdint>
#include <vector>

namespace vdbcloud {

/// How the optical depth between a voxel and a directional light is found.
enum class Fidelity {
    Lattice,  ///< persistent rays on a lattice along the light (sweep/light_lattice.h): time proportional to the voxels
    Exact     ///< a ray of its own for each voxel, exact for the trilinear density: the reference for Lattice
};

struct TransmittanceOptions {
    Fidelity fidelity = Fidelity::Lattice;  ///< point lights are always exact
    int rays_per_voxel = 3;                 ///< of the lattice; its error falls as the square
    int refine = 1;                         ///< light-grid points a voxel along each axis, 1..8
    int disc_samples = disc_directions;     ///< directions over the disc of a light with an angular diameter
    int error_samples = 1000;               ///< voxels at which the lattice is compared with exact rays; 0: none
    /// Index axes along which the medium repeats without end, by the rule of period_of(). Rays are then always exact,
    /// and lights are at infinity.
    std::array<bool, 3> periodic{false, false, false};
    /// Hide lights: T is 0 at voxels whose centre a solid keeps from the light, and those within a solid. Of a disc's
    /// directions each is seen or hidden.
    std::vector<Solid> solids{};
};

struct TransmittanceReport {
    int64_t voxels = 0;
    int compared = 0;       ///< voxels that were compared with exact rays
    double mean_error = 0;  ///< mean |T - T_exact| over them
    double max_error = 0;
    int64_t hidden = 0;  ///< voxels that solids keep from all of the light
    Workload work;       ///< events of data/unit_costs.txt, but for cells of exact rays
    EffectCosts costs;
};

/// What bounds the error of a light's grid. Nothing is known of a grid that was not compared.
Accuracy accuracy_of(const TransmittanceReport&);

/// transmittance_<light>: T(x) = exp(-sigma_t_per_density * depth(x)), depth the density integrated from the voxel's
/// centre to the light; averaged over the light's disc if it has one.
///
/// Values are at the active voxels of `density` and one voxel about them, which is where a trilinear sample of a lit
/// point inside the cloud can reach; elsewhere the background is 1. Float where the medium is grey, else vec3s. With
/// refine = m the light grid's voxels are m times smaller than density's, of which every m-th lies on one of density's
/// centres: interpolating T between them then errs m^2 times less. The grid bears density's transform (refined), the
/// light (write_light), the medium's extinction and density's digest as metadata, so that later stages know what it
/// belongs to; with solids also schema::solids, their fingerprint.
///
/// In a periodic medium a grid holds one period and one voxel about it, bears schema::periodic, and T is that of all
/// copies.
///
/// Units: sigma_t_per_density [1/world unit]. Errors: InputError for a transform that is not affine, or a light that a
/// periodic medium does not allow.
/// Source: Kajiya & Von Herzen 1984, section 3.1, pass one.
GridBasePtr transmittance_grid(const FloatGrid& density, const Medium& medium, const Light& light,
                               const TransmittanceOptions& options, const Progress& progress = {},
                               TransmittanceReport* report = nullptr);

/// In place of the grid of a light that adds nothing: a grid without voxels, whose metadata describe the light.
GridBasePtr unlit_grid(const FloatGrid& density, const Light& light);

/// What transmittance_grid() would do and hold.
struct TransmittancePlan {
    Workload work;
    double bytes = 0;        ///< at the peak, the grid included
    double grid_bytes = 0;   ///< of the grid
    double value_bytes = 0;  ///< of the grid's values, as files store them
};

/// The plan for one light. With `count` the events are counted, too, from the medium's blocks and some rays, in a small
/// part of the time of the light itself.
TransmittancePlan transmittance_plan(const FloatGrid& density, const Medium& medium, const Light& light,
                                     const TransmittanceOptions& options, bool count);

/// One of several media that light crosses.
struct CrossedMedium {
    FloatGridPtr density;  ///< may be empty
    Medium medium;
};

/// transmittance_<light> at the voxels of one of several media, through all of them:
///
///     T(x) = mean over the light's disc of exp(-sum over media of sigma_t_per_density * depth(x))
///
/// Values are at the voxels of media[at] as above, and mean nothing elsewhere: each medium needs a grid of its own.
/// Vec3s where any medium is coloured. The lattice of rays serves every medium whose lattice is that of media[at] up to
/// a shift (with refine above 1: that coincides with it). Other media, and lights at a finite distance, cost an exact
/// ray for each voxel. The depths of one light do not depend on the order of the media beyond rounding.
///
/// `own`, which may be null: a transmittance grid of media[at] alone. It is returned as it is if no other medium
/// reduces the light of any voxel. The metadata are those of a grid of media[at] without the density's digest, so that
/// no later stage takes the grid for one of media[at] alone.
GridBasePtr transmittance_grid(const std::vector<CrossedMedium>& media, size_t at, const Light& light,
                               const TransmittanceOptions& options, const GridBasePtr& own = nullptr,
                               const Progress& progress = {});

}  // namespace vdbcloud
