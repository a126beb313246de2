#pragma once
// Multiple scattering by P1: from a density and its lights to phi and flux, all three channels.
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scatter/flux_limiter.h"
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scatter/second_moment.h"
#include "vdbcloud/scatter/sky_inflow.h"
#include "vdbcloud/scene/light.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

enum class P1Solver { Multigrid, Relaxation };

struct ScatterOptions {
    bool delta = true;  ///< delta-Eddington scaling; false is the paper's plain form
    Sky sky;            ///< around it; black: none
    std::array<bool, 3> periodic{false, false, false};
    int rays_per_voxel = 2;  ///< of the light lattice
    P1Solver solver = P1Solver::Multigrid;
    double relaxation = 1.9;  ///< factor of successive over-relaxation
    SolveOptions solve;
    bool limiter = false;  ///< Levermore & Pomraning's (flux_limiter.h): solutions of two lights no longer add up
    double limiter_change = 1e-4;  ///< its iteration ends when phi changes by less
    int limiter_iterations = 100;
    int reentry_rays = 20000;  ///< for the estimate of light that would enter again; 0: none
    ClosureOptions closure;    ///< sweeps that close P1
    Vec3d up{0, 1, 0};         ///< world; the polar axis of the sweeps' directions is the index axis nearest to it
    int keep_moments = 7;      ///< degree up to which moments become grids, at least 1: phi and flux
    int line_rays = 1;         ///< measure what each sun loses by lines through the medium; 0: not
};

/// How one channel went.
struct ChannelReport {
    int solved_as = 0;  ///< the channel whose solution it shares, itself if it was solved
    double scale = 1;   ///< times that solution
    SolveResult solve;
    P1Budget budget;
    ClosureReport closure;
    LimiterReport limiter;
    double deposited = 0;  ///< power that the beams lost in the medium, by faces
    double lines = -1;     ///< the same by lines across each sun; -1: not measured
    double beam_in = 0, beam_out = 0, emitted = 0;
    double reflected = 0, transmitted = 0;  ///< diffuse, on the sides that see the first sun and on the others
    int64_t flux_limited = 0;               ///< voxels whose flux was shortened for the picture (limit_flux)
    double reentry =
        -1;  ///< share of the diffuse outflow that would hit the medium again, and is lost; -1: not measured
};

struct ScatterReport {
    std::array<ChannelReport, 3> channel;
    size_t voxels = 0, blocks = 0, exposed = 0;
    size_t bytes = 0;  ///< greatest sum of the arrays that were alive together
    int levels = 0;
    int solves = 0;
    bool converged = true;
    bool emission_outside = false;  ///< there is emission where no density is: it does not enter
};

struct ScatterFields {
    Vec3SGridPtr phi;                  ///< null if there is no voxel above 0
    std::array<Vec3SGridPtr, 3> flux;  ///< of r, g, b; world components
    /// Of degree 2 and more (schema::moment_name) for each channel, by rising l and m, harmonics about the world's
    /// axes. Channels that are multiples of one solution share the grids of the first.
    std::array<std::vector<FloatGridPtr>, 3> moments;
    Vec3d moment_scale{1, 1, 1};  ///< what r, g, b are of their grids; not 1 only where they share them
    DeltaScaling scaling;         ///< of the medium that all of this belongs to
};

/// Solves the P1 equations (p1_problem.h) for each channel of a medium lit by `lights`, a sky and emission.
///
/// `tint` (Cd) multiplies the albedo per voxel, `emission` is a radiance per world unit; either may be null. Channels
/// with equal coefficients share matrix and hierarchy; those whose light is a multiple of another's share the solution.
/// The beams are computed here, from the lights, in the scaled medium: a stored transmittance is 0 where T' is not.
///
/// phi and flux are collided light only, of the SCALED medium, and bear it as metadata (the delta scaling, the
/// medium): an image is formed there too. With w0, sigma_t of the true medium, s towards the eye and p the true phase
/// function (Nakajima & Tanaka 1988, TMS), everything attenuated by sigma_t' = (1 - w0 f) sigma_t:
///
///     single scattering    w0 sigma_t p(cos) E T', times what the forward peak scatters again (render/forward_peak.h)
///     multiple scattering  w0' sigma_t' / (4 pi) (phi + 3 m_1' s.F),   w0' sigma_t' = w0 (1 - f) sigma_t
///
/// P1's flux is shortened to |F| <= phi / 3 where it is longer and the mean cosine is not 0 (limit_flux).
///
/// With closure.iterations > 0 sweeps go on from P1 to the transport equation (second_moment.h); scaling and moments
/// are then of closure.degree, and the second line is the sum over l <= degree of m_l' Y_lm(s) M_lm.
///
/// Errors: InputError (shear, coefficients out of range, a light that a periodic medium cannot have); a solver that
/// misses its tolerance is told by the report. Throws Cancelled.
ScatterFields scatter_p1(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         const Progress& progress, ScatterReport& report);

/// Share of the outflow that leaves exposed faces and would hit an active voxel again, by cosine-distributed rays about
/// the surface's normal. Deterministic.
double reentry_share(const P1Operator&, const P1Source&, const std::vector<double>& phi, int rays);

}  // namespace vdbcloud
