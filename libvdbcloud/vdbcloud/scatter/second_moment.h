#pragma once
// From P1 to the transport equation: discrete-ordinates sweeps that close the P1 equations.
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

struct ClosureOptions {
    int iterations = 0;   ///< sweeps at most; 0 is P1
    int directions = 32;  ///< at least (ordinates.h)
    OrdinateKind kind = OrdinateKind::Product;
    int degree = 1;        ///< of the scattering source's expansion and of the delta-M scaling, 1..7
    double change = 1e-3;  ///< stop when an iteration changes collided light by less (ClosureReport::change)
};

/// How a set of directions lies in the grid (ordinates.h).
struct OrdinateFrame {
    int polar = 1;         ///< index axis that the product set's polar cosine is measured from
    bool layered = false;  ///< the medium is a layer across that axis, without end along the others
};

/// What the sweeps did.
struct ClosureReport {
    size_t directions = 0;  ///< of the set in use
    int iterations = 0;
    bool converged = false;  ///< the last change was below the one asked for
    /// By each iteration, of the light it was given: of phi, and where scattering is not isotropic of the flux too,
    /// root mean square relative to their own. It is the residual of the fixed point, so how the next start is mixed
    /// does not hide in it.
    std::vector<double> change;
    std::vector<double> seconds;  ///< of each iteration
    double contraction = 0;       ///< of the changes, the geometric mean of the last three at most
    double error = 0;             ///< estimate of what is left, change x contraction / (1 - contraction); -1: not known
    std::vector<SolveResult> solves;
};

/// Memory of the iteration's history, for scattering of mean cosine `g`.
size_t mixing_bytes(size_t slots, double g);

/// The exposed voxels that a closed P1 operator is to be made with: their weights brought towards 1 where a voxel is
/// thick, w + (1 - w) x^2 / (1 + x^2), x = sigma_tr h. A face of small weight lets nothing out by the matrix, and what
/// leaves is left to the correction, one iteration late: behind many mean free paths of voxel that feeds on itself and
/// grows.
std::vector<ExposedVoxel> closure_exposed(const P1Operator&);

/// Second-moment method for one channel.
///
/// Each iteration sweeps radiance through the voxels (sweep/transport_sweep.h) with the source
///
///     q = S / sigma_t' = w0' sum over l <= degree of m_l' sum over m of Y_lm(s) (M_lm + U_lm) + j / sigma_t'
///
/// with m_l' the scaled moments of the phase function (optics/delta_scaling.h), U the moments of the uncollided light,
/// M_00 from P1 and the higher M_lm from the sweep before, to P1's scale; then P1 is solved again with what the sweep
/// knows and P1 does not: t = int (s s - I/3) L in the cells and on exposed faces, which enters as
///
///     F = -(grad phi / 3 + div t) / sigma_tr + Q1 / sigma_tr,
///
/// and on exposed faces c = F.n - w (phi / 2 - 2 J). P1 owns phi: it is conservative at any optical depth of a voxel
/// and converges in a few iterations at any albedo, where sweeps alone need hundreds. (P1's own F is not fed back: at g
/// = 0.85 that grows.) A white furnace stays exact: t and c are 0 in it. The next sweep's start is mixed from the last
/// few results (mixing.h): moments of degree 1 fall only by m_1' an iteration in thick parts, and among jumps of 1e6
/// the plain iteration may grow (Warsa, Wareing & Morel 2004). What is returned is P1's own solution and not a mixture.
///
/// Source: Kajiya & Von Herzen 1984, section 4, is the equation; Lewis & Miller 1976 (second-moment method); Wiscombe
/// 1977 (delta-M).
class SecondMoment {
public:
    /// Keeps references; `p1.medium().degree` is the options' degree, its exposed voxels are closure_exposed(). Throws
    /// InputError if the degree is not 1..7 or no set of directions is large enough.
    SecondMoment(const P1Operator& p1, const ClosureOptions& options, const OrdinateFrame& frame = {});

    /// One light's uncollided fluence (beam_fluence()) times `strength`, travelling as the light's beam does.
    void add_uncollided(const Light& light, const std::vector<float>& fluence, double strength);
    /// Emission j [radiance / world unit], times `factor`.
    void add_emission(const std::vector<float>& emission, double factor);
    /// Radiance that enters along each of set().direction; a uniform sky's.
    void set_sky(double radiance) { set_.inflow.assign(ordinates_.count(), float(radiance)); }
    void set_sky(std::vector<float> along) { set_.inflow = std::move(along); }

    /// Moments of what the first sweep shall take as collided light beyond phi: `fluence` times `strength` along the
    /// light's beam.
    void start_with(const Light& light, const std::vector<float>& fluence, double strength);
    /// P1's flux as the first sweep's moments of degree 1.
    void start_with_flux(const std::array<std::vector<float>, 3>& flux);

    /// Iterates. `base` is P1's source (beams, sky, emission); phi the start and the result. On return `source` is the
    /// last P1's with all terms (its rhs used up), for budget() and cell_flux().
    ClosureReport run(Multigrid&, const SolveOptions&, const P1Source& base, std::vector<double>& phi,
                      P1Source& source);

    /// Moments of collided light in real spherical harmonics about the index axes (harmonics.h): degree 0 is phi /
    /// sqrt(4 pi) of P1, the others are the last sweep's times P1's phi over the sweep's own.
    /// harmonic_count(max(degree, 2)) arrays.
    const std::vector<std::vector<float>>& moments() const { return swept_.moments; }
    const Ordinates& set() const { return ordinates_; }
    size_t bytes() const;

private:
    void take_phi(const std::vector<double>& phi);
    void build_source();
    void close(P1Source& source) const;
    void close_face(P1Source& source, size_t exposed, int face, const FaceTally& tally) const;
    double tensor(int a, int b, size_t slot) const;
    double cross_gradient(int axis, size_t slot) const;
    void add_beam_moments(const Light& light, const std::vector<float>& fluence, double strength,
                          std::vector<std::vector<float>>& moments) const;

    const P1Operator& p1_;
    ClosureOptions o_;
    Ordinates ordinates_;
    std::vector<SweepFace> faces_;
    SweepSet set_;
    int terms_;  // harmonics of the source: up to the last scaled moment that is not 0
    std::vector<float> sigma_;
    std::vector<std::vector<float>> uncollided_, source_;
    std::vector<float> emission_;
    SweepResult swept_;
};

}  // namespace vdbcloud
