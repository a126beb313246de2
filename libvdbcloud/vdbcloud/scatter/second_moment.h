#pragma once
// From P1 to the transport equation: discrete-ordinates sweeps that close the P1 equations.
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include <memory>
#include <optional>

namespace vdbcloud {

struct LitWalls;

struct ClosureOptions {
    int iterations = 0;   ///< maximum number of sweeps; 0: P1 only
    int directions = 32;  ///< minimum number of directions (ordinates.h)
    OrdinateKind kind = OrdinateKind::Product;
    int degree = 1;        ///< of the scattering source's expansion and of the delta-M scaling, 1..7
    double change = 1e-3;  ///< stop when ClosureReport::change of an iteration is below this value
    /// Tolerance of the solves between sweeps over the last change, relative to the right side of phi's equation. It
    /// moves phi by less than a hundredth of the change that is left. 0: SolveOptions::tolerance.
    double solve_share = 1e-3;
};

/// Tolerance of a solve between sweeps, given the last change: at least that of `options`.
double tolerance_between(const ClosureOptions&, const SolveOptions& options, double change);
/// The same of P1's solution from which sweeps start.
double tolerance_before(const ClosureOptions&, const SolveOptions& options);

/// The exposed faces, in the order of SweepResult::tally.
std::vector<SweepFace> faces_of(const std::vector<ExposedVoxel>&);

/// Orientation of a set of directions in the grid (ordinates.h).
struct OrdinateFrame {
    int polar = 1;         ///< index axis that the product set's polar cosine is measured from
    bool layered = false;  ///< the medium is a layer across that axis, periodic along the other axes
};

/// The polar axis is the index axis nearest to `up` [world]; in a layer (two periodic axes) it is the axis across it.
OrdinateFrame frame_of(const VoxelIndex&, const std::array<bool, 3>& periodic, const Vec3d& up);

/// Convergence history of the sweeps.
struct ClosureReport {
    size_t directions = 0;  ///< number in the set used
    int iterations = 0;
    bool converged = false;  ///< the last change was below ClosureOptions::change
    /// Relative change of collided light in each iteration, root mean square: of phi, and with anisotropic scattering
    /// of the flux too. This is the residual of the fixed point, before the next start is mixed.
    std::vector<double> change;
    std::vector<double> seconds;  ///< of each iteration
    /// Ratio of successive changes: geometric mean over at most the last three.
    double contraction = 0;
    /// Estimate of the remaining error, change x contraction / (1 - contraction); -1: not known.
    double error = 0;
    std::vector<SolveResult> solves;
};

/// Memory of the iteration's history, for scattering of mean cosine `g`.
size_t mixing_bytes(size_t slots, double g);

/// The exposed voxels, those of P1 given, from which to make a P1 operator that sweeps close. Weights approach 1 where
/// a voxel is optically thick: w + (1 - w) x^2 / (1 + x^2), x = sigma_tr h. Through a face of small weight the matrix
/// lets out little, so the outflow comes from the correction of the previous iteration. In voxels of many mean free
/// paths this delay makes the iteration diverge.
std::vector<ExposedVoxel> closure_exposed(const P1Cells&, std::vector<ExposedVoxel> of);

/// Second-moment method for one channel.
///
/// Each iteration sweeps radiance L through the voxels (sweep/transport_sweep.h) with the source
///
///     q = S / sigma_t' = w0' sum over l <= degree of m_l' sum over m of Y_lm(s) (M_lm + U_lm)
///
/// with m_l' the scaled moments of the phase function (optics/delta_scaling.h), U the moments of the uncollided light,
/// sqrt(4 pi) M_00 = phi, and the higher M_lm the previous sweep's. The light of suns is scattered for the first time
/// by the phase function itself (first_scattering.h), with the moments of the expansion. The light of emission j that
/// has not collided is part of L: one sweep with the source j, which all iterations share. Then the balance of each
/// cell is solved for phi,
///
///     div F + sigma_a phi = Q0,   F = J + W (F_P1 - J) - D (grad phi - grad phi_L),
///     F_P1 = -(grad phi_L / 3 + div t) / sigma_tr + Q1 / sigma_tr
///
/// where phi_L, J = int s L and t = int (s s - I/3) L are the sweep's. On exposed faces J is the sweep's current, F_P1
/// is c + w (phi_b / 2 - 2 J_sky) with c = J.n - w (int L / 2 - 2 J_sky), and phi - phi_L leaves as in P1. D is
/// P1's, bounded where the medium is thin (streaming.h).
///
/// At the fixed point phi is the sweep's wherever that is a solution of the balance, so in voxels that are optically
/// thin: there P1's law of the flux with t from differences of voxels is the worse of the two. Where voxels are thick
/// it is P1's, which has the diffusion limit at any thickness. The weight W (diffusive()) is of the medium alone, so
/// light is linear in its sources: two suns add up to `change`. The balance holds exactly in either case, and a white
/// furnace stays exact: J, t and phi - phi_L are 0.
///
/// phi comes from P1's matrix, so iterations are few at any albedo; sweeps alone need hundreds. Higher moments come
/// from the sweep as they are: at g = 0.85 the iteration would diverge with P1's flux in them.
///
/// The next sweep's start is mixed from the last few results (mixing.h), for two reasons. In thick parts the error of
/// moments of degree 1 falls only by the factor m_1' per iteration. With density jumps of 1e6 the plain iteration may
/// diverge (Warsa, Wareing & Morel 2004). run() returns the last solution, not a mixture.
///
/// Source: Kajiya & Von Herzen 1984, section 4, is the equation; Lewis & Miller 1976 (second-moment method); Wiscombe
/// 1977 (delta-M); W: none, measured on slabs and clouds (docs/scattering.md).
class SecondMoment {
public:
    /// Keeps references. Requires `p1.medium().degree` == `options.degree` and exposed voxels from closure_exposed().
    /// Throws InputError if the degree is outside 1..7 or no set of directions is large enough.
    /// `transport`, if given, is of faces_of(p1); sweeps of equal directions then find what they need of geometry once.
    /// `like`, if given, is another channel of the same options and voxels: where their extinction is equal, the two
    /// share its arrays.
    SecondMoment(const P1Operator& p1, const ClosureOptions& options, const OrdinateFrame& frame = {},
                 TransportSweep* transport = nullptr, const SecondMoment* like = nullptr);

    /// Adds a light's uncollided fluence (beam_fluence()) times `strength`, along the light's beam. `disc` is the unit
    /// vector towards the middle of the sun that `light` is a part of, if it is: all parts scatter for the first time
    /// as that does (first_scattering()). Lights at finite distance scatter by the expansion.
    void add_uncollided(const Light& light, const std::vector<float>& fluence, double strength,
                        const std::optional<Vec3d>& disc = std::nullopt);
    /// Adds moments of uncollided light about the index axes, by harmonic; those beyond the source's are left out.
    void add_uncollided(const std::vector<std::vector<float>>& moments);
    /// Adds emission j [radiance / world unit] times `factor`. Its light up to the first collision is swept once, with
    /// j linear from voxel to voxel (SweepFields::emission), and added to the light of each sweep.
    void add_emission(const std::vector<float>& emission, double factor);
    const std::vector<std::vector<float>>& uncollided() const { return uncollided_; }
    /// Takes `light` [radiance / world unit] from what is scattered into each direction.
    void scatter_less(const std::vector<float>& light);
    /// Sets the radiance that enters along each of set().direction: one value for a uniform sky, or one per direction.
    void set_sky(double radiance) { set_.inflow.assign(ordinates_.count(), float(radiance)); }
    void set_sky(std::vector<float> along) { set_.inflow = std::move(along); }
    /// Sets the ground that every sweep meets; its irradiance is that of the last sweep. Null: none.
    void set_ground(SweepGround* ground) { ground_ = ground; }
    /// Sets the solids that every sweep meets, lit for the first sweep; each sweep lights them anew. Null: none.
    void set_walls(LitWalls* walls) { walls_ = walls; }

    /// Adds moments of `fluence` times `strength` along the light's beam to the collided light from which the first
    /// sweep starts. phi itself is not changed.
    void start_with(const Light& light, const std::vector<float>& fluence, double strength);
    /// Whether the source depends on the flux: not of light that is scattered alike into all directions.
    bool takes_flux() const { return terms_ > 1; }
    /// Adds `factor` times P1's flux, as moments of degree 1, to the collided light from which the first sweep starts.
    void start_with_flux(const std::array<std::vector<float>, 3>& flux, double factor = 1);

    /// Takes these moments of degree 1 and more, about the index axes, for those of the collided light from which the
    /// first sweep starts, at the slots that are `known`; moments that are not there are 0.
    void start_with_moments(const std::vector<std::vector<float>>& moments, const std::vector<char>& known);

    /// Iterates. `source` is P1's source (beams, sky, emission) on entry, and has what budget() takes on return,
    /// without right side and additive fluxes. phi is the start on entry and the result on return.
    /// ClosureReport::solves tell of the solve for phi - phi_L, to tolerance_between() of that difference. `planes`, if
    /// given, is the last sweep's light through the planes of the box about the voxels, as PlaneLight::by_cell
    /// requests.
    ClosureReport run(Multigrid&, const SolveOptions&, P1Source& source, std::vector<double>& phi,
                      PlaneLight* planes = nullptr);
    /// run() for several channels, iteration by iteration: those that share extinction are swept together, and solves
    /// start from what those of the channels before have changed. Each has the result of a run of its own, within the
    /// tolerance of the solves.
    struct Channel {
        SecondMoment* closure;
        Multigrid* multigrid;
        P1Source* source;
        std::vector<double>* phi;
        PlaneLight* planes;
    };
    static std::vector<ClosureReport> run(const std::vector<Channel>&, const SolveOptions&);
    /// One sweep of the light that phi and the starts above give, on the planes and the ground alone. Null: no planes.
    void sweep_planes(const std::vector<double>& phi, PlaneLight* planes);

    /// Moments of collided light in real spherical harmonics about the index axes (harmonics.h): degree 0 is phi /
    /// sqrt(4 pi), higher degrees are the last sweep's. harmonic_count(degree) arrays, and others that are empty.
    const std::vector<std::vector<float>>& moments() const { return swept_.moments; }
    /// Gives the moments away.
    std::vector<std::vector<float>> take_moments() { return std::move(swept_.moments); }
    const Ordinates& set() const { return ordinates_; }
    /// Whether this and another channel share the arrays of their extinction.
    bool shares_extinction(const SecondMoment& other) const { return sigma_ == other.sigma_; }
    /// Arrays of a shared extinction are those of the channel that was given as `like`.
    size_t bytes() const;

private:
    class Swept;
    class Run;
    void take_phi(const std::vector<double>& phi);
    static double fluence_of(float moment);
    void take_excess(const std::vector<float>& swept, const std::vector<double>& excess);
    void build_source();
    void drop_source();
    void drop_moments();
    std::vector<float> thickest() const;
    template<typename F>
    void each_face(const F& f) const;
    std::vector<double> take_replaced(P1Source& source) const;
    struct Sweep;
    WallLight* walls() const;
    static void run_together(const std::vector<Sweep>&, bool emission);
    static void sweep_emission(const std::vector<Channel>&);
    static void sweep(const std::vector<Sweep>&);
    void add_glow(const Sweep&) const;
    void close(P1Source& source, const std::vector<double>& outflow) const;
    void close_face(const Swept&, P1Source& source, size_t exposed, int face, const FaceTally& tally,
                    double additive_outflow) const;
    std::vector<float>& first_scattered(size_t medium, const Vec3d& along);
    void add_beam_moments(const Light& light, const std::vector<float>& fluence, double strength,
                          std::vector<std::vector<float>>& moments) const;

    const P1Operator& p1_;
    ClosureOptions o_;
    Ordinates ordinates_;
    size_t faces_ = 0;
    std::unique_ptr<TransportSweep> own_;
    TransportSweep& transport_;
    SweepSet set_;
    int terms_;                                        // harmonics of the source: up to the last nonzero scaled moment
    std::shared_ptr<const std::vector<float>> sigma_;  // sigma_t'
    bool owns_sigma_ = true;
    std::vector<std::vector<float>> uncollided_, source_;  // terms of harmonics are empty between sweeps
    /// The medium that scatters and the ways of suns' light, along the index axes: a term of the source for each.
    std::vector<std::pair<size_t, Vec3d>> suns_;
    std::vector<float> less_;                   // of the source; empty: nothing
    std::vector<std::vector<float>> emission_;  // j / sigma_t' by Y_00: one array, or none
    struct Glow {
        SweepResult light;
        PlaneLight planes;
        std::vector<float> on_ground, on_walls;
    };
    Glow glow_;  // what emission_ brings before it collides
    SweepResult swept_;
    SweepGround* ground_ = nullptr;
    LitWalls* walls_ = nullptr;
};

}  // namespace vdbcloud
