#pragma once
// Multiple scattering by P1: from a density and its lights to phi and flux, all three channels.
#include "vdbcloud/core/effects.h"
#include "vdbcloud/core/workload.h"
#include "vdbcloud/grid/accuracy.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scatter/flux_limiter.h"
#include "vdbcloud/scatter/flux_map.h"
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scatter/previous_light.h"
#include "vdbcloud/scatter/second_moment.h"
#include "vdbcloud/scatter/sky_inflow.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/solid.h"

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

enum class P1Solver { Multigrid, Relaxation };

struct ScatterOptions {
    bool delta = true;  ///< delta-Eddington scaling; false is the paper's plain form
    Sky sky;            ///< around the medium; black: no sky
    /// Albedo of a Lambertian ground beneath the medium (scene/ground.h), which hides the sky below the horizon; none:
    /// light that leaves downwards is lost.
    std::optional<double> ground_albedo;
    std::array<bool, 3> periodic{false, false, false};
    /// Opaque bodies: voxels whose centre is within one are no part of the medium, and solids hide suns and lamps. For
    /// sweeps they are walls, too, which send back what they receive as a diffuse surface does (solid_walls.h), mirrors
    /// and glossy ones that of suns and lamps excepted. P1 alone leaves out what they reflect into the medium, and what
    /// they hide of the sky and of other parts of the medium.
    std::vector<Solid> solids{};
    /// Media that overlap and keep their phase functions, on one lattice: JoinedMedium::parts. The density is then
    /// their sum, and coefficients, phase function and tint are those of the parts; empty: one medium.
    std::vector<MediumPart> parts{};
    int rays_per_voxel = 2;              ///< of the light lattice
    int disc_samples = disc_directions;  ///< directions over the disc of a light with an angular diameter
    P1Solver solver = P1Solver::Multigrid;
    double relaxation = 1.9;  ///< factor of successive over-relaxation
    SolveOptions solve;
    bool limiter = false;  ///< Levermore & Pomraning's (flux_limiter.h); makes the solution nonlinear in the lights
    double limiter_change = 1e-4;  ///< the limiter's iteration ends below this relative change of phi
    int limiter_iterations = 100;
    /// Rays that estimate light which leaves and hits the medium again, and for P1 alone the planes that light leaves
    /// through; 0: none.
    int reentry_rays = 20000;
    ClosureOptions closure;  ///< transport sweeps that close P1
    /// The light of an earlier frame, from which the sweeps start wherever its matter has come from; null: P1's light.
    /// The fixed point of the sweeps does not depend on it. Not where emission is followed by rays in only one of the
    /// frames: what differs is made up by the sweeps.
    std::shared_ptr<const PreviousLight> previous;
    /// Follow emission by rays up to its first collision where few voxels emit (emitted_light.h). Else, over a ground,
    /// with `limiter`, and in a periodic medium emission is a source of P1 and the sweeps, as the series takes it.
    bool emission_by_rays = true;
    Vec3d up{0, 1, 0};      ///< [world]; the sweeps' polar axis is the index axis nearest to `up`
    int keep_moments = 7;   ///< highest degree of moments written as grids; 1: phi and flux only
    int line_rays = 1;      ///< 1: measure each sun's lost power by lines through the medium; 0: do not
    bool flux_map = false;  ///< make ScatterReport::flux_map. For P1 alone: by one sweep of closure.directions
    bool heating = false;   ///< make ScatterReport::heating
    /// Lights of the scene that reach no voxel: metadata name them, and nothing else is done for them.
    std::vector<Light> hidden_lights{};
    bool channels_apart = false;  ///< no channel shares the solution of another
};

/// Powers of a ground [radiance x (world unit)^2]. Of an endless ground under a medium that ends on all sides: what the
/// medium changes on the patch (endless_ground.h). `direct` is then below 0, the shadow.
struct GroundPower {
    double direct = 0, diffuse = 0;  ///< on the ground: of the beams; of all other light
    double sent_up = 0, absorbed = 0;
};

/// Result and power balance of one channel. Powers in units of radiance x (world unit)^2.
struct ChannelReport {
    int solved_as = 0;  ///< channel whose solution this channel uses; its own number if solved
    double scale = 1;   ///< factor of that solution
    SolveResult solve;
    P1Budget budget;
    ClosureReport closure;
    LimiterReport limiter;
    double deposited = 0;  ///< power that the beams lose in the medium, by voxel faces
    double lines = -1;     ///< power that the suns lose, by lines through the medium; -1: not measured (or a lamp)
    double beam_in = 0, beam_out = 0, emitted = 0;
    bool emission_by_rays = false;
    double emission_scaled_by = 0;  ///< change of uncollided emission that makes its powers balance (emitted_light.h)
    int emission_collisions = 0;    ///< collisions within emitting voxels that were followed by rays
    GroundPower ground;             ///< 0 without a ground
    PlanePower planes;              ///< not known for P1 alone without reentry_rays and flux_map
    int64_t flux_limited = 0;       ///< voxels whose flux pictures shorten (CollidedLight::flux_limit)
    /// Share of the diffuse outflow that would hit the medium again and that P1 loses; -1: not measured.
    double reentry = -1;
};

struct ScatterReport {
    std::array<ChannelReport, 3> channel;
    size_t voxels = 0, blocks = 0, exposed = 0;
    size_t from_previous = 0;  ///< voxels that start from ScatterOptions::previous
    size_t bytes = 0;          ///< peak memory of the solve's arrays
    Workload work;             ///< events of data/unit_costs.txt
    EffectCosts costs;
    int levels = 0;
    int solves = 0;
    bool converged = true;
    bool emission_outside = false;  ///< emission where density is 0 was ignored
    /// Few voxels emit, and rays did not follow their light: options or a periodic medium do not allow it.
    bool emission_without_rays = false;
    bool solids = false;              ///< there are solids
    bool endless_ground = false;      ///< a ground under a medium that ends on all sides (GroundPower)
    int top = Blocks::YPlus;          ///< the plane that faces up, across the index axis nearest to ScatterOptions::up
    std::optional<FluxMap> flux_map;  ///< on request (ScatterOptions)
    GridBasePtr heating;              ///< on request: absorbed power per volume (docs/format.md)
    GridBasePtr ground;               ///< with a ground: its radiance (docs/format.md)
};

/// What bounds the error of the solution, the worst of the channels; and what it leaves out.
Accuracy accuracy_of(const ScatterReport&, const std::vector<Light>&);

/// Solves the P1 equations (p1_problem.h) for each channel of a medium lit by `lights`, a sky and emission.
///
/// `tint` (Cd) multiplies the albedo per voxel, `emission` is a radiance per world unit; either may be null. Channels
/// with equal coefficients share matrix and hierarchy. Channels whose lights are proportional share the solution. Beams
/// are computed from the lights in the scaled medium: a stored transmittance can be 0 where T' is not.
///
/// phi and flux are collided light only, of the SCALED medium. Their metadata hold the delta scaling and the medium,
/// and render forms the image in the scaled medium too. With w0, sigma_t of the true medium, s towards the eye and p
/// the true phase function (Nakajima & Tanaka 1988, TMS), both attenuated by sigma_t' = (1 - w0 f) sigma_t:
///
///     single scattering    w0 sigma_t p(cos) E T', times what the forward peak scatters again (render/forward_peak.h)
///     multiple scattering  w0' sigma_t' / (4 pi) (phi + 3 m_1' s.F),   w0' sigma_t' = w0 (1 - f) sigma_t
///
/// The light is linear in all sources. Pictures of P1 alone shorten the flux to longest_flux x phi where the mean
/// cosine is not 0: CollidedLight::flux_limit.
///
/// With closure.iterations > 0 transport sweeps refine P1 to the transport equation (second_moment.h). Scaling and
/// moments are then of closure.degree, and multiple scattering is the sum over l <= degree of m_l' Y_lm(s) M_lm.
///
/// With ScatterOptions::ground_albedo light is reflected by a ground. Beneath a medium that repeats: column by column
/// in sweeps, by partial currents in P1, which needs a medium without gaps in its lowest layer. Beneath a medium that
/// ends on all sides the ground is endless (endless_ground.h). The limiter takes no ground.
///
/// Errors: InputError for solids in a periodic medium, for shear, coefficients out of range, a light that a periodic
/// medium does not allow, or a ground that the medium does not allow (ground.h). A solver that misses its tolerance
/// sets ScatterReport::converged to false. Throws Cancelled.
CollidedLight scatter_p1(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         const Progress& progress, ScatterReport& report);

/// Share of the outflow through exposed faces that would hit an active voxel again, estimated by `rays` rays,
/// cosine-distributed about the surface normal. Deterministic.
double reentry_share(const P1Operator&, const P1Source&, const std::vector<double>& phi, int rays);

/// Fluence of one channel at the slots of an index.
using FluenceOf = std::function<std::vector<double>(const VoxelIndex&, int channel)>;

/// P1's light of fluence that is known, for example from a series: flux, budget and grids as scatter_p1() makes them
/// after a solve, at the cost of its beams. ChannelReport::solve has the residual and the error estimate of that
/// fluence.
CollidedLight p1_light(const FloatGrid& density, const Vec3SGrid* emission, const Medium& medium,
                       const std::vector<Light>& lights, const ScatterOptions& options, const FluenceOf&,
                       ScatterReport& report);

}  // namespace vdbcloud
