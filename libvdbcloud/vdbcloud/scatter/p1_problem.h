#pragma once
// The P1 equations of one colour channel on the active voxels: conservative matrix, sources, solution, power balance.
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/scatter/boundary.h"
#include "vdbcloud/scatter/harmonics.h"
#include "vdbcloud/solve/conjugate_gradient.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

namespace vdbcloud {

/// Media of different phase functions that overlap in the cells of one channel.
struct MixedPhases {
    std::vector<PhaseFunction> phase;  ///< of each medium
    /// Share of the media after the first in the scattering coefficient of each slot; the first has what they leave.
    std::vector<std::vector<float>> share;

    double share_of(size_t medium, size_t slot) const
    {
        if (medium > 0) return share[medium - 1][slot];
        double left = 1;
        for (const auto& others : share) left -= others[slot];
        return std::max(left, 0.0);
    }
};

/// The medium of one channel.
struct P1Medium {
    double sigma_t_per_density = 1;            ///< [1/world unit] at density 1
    double albedo = 1;                         ///< w0, in [0, 1]
    const std::vector<float>* tint = nullptr;  ///< factor of w0 for each slot; null: 1 everywhere
    PhaseFunction phase;
    bool delta = true;  ///< delta-M scaling (optics/delta_scaling.h)
    int degree = 1;     ///< of the scaling; 1: delta-Eddington, the right choice for P1 without sweeps
    const std::vector<float>* limiter = nullptr;  ///< factor of D for each slot; null: 1 everywhere
    double ground_albedo = 0;                     ///< on the faces of ExposedVoxel::grounded (ground.h)
    /// Phase functions in place of `phase`, which stands for none of them; null: one phase function.
    const MixedPhases* mixed = nullptr;
};

/// Coefficients of one cell in the scaled medium.
struct ScaledCell {
    double albedo = 1;      ///< w0'
    double extinction = 1;  ///< sigma_t' / sigma_t
};

/// The weight of diffusion against the sweep in a voxel of an optical thickness [mean free paths of the scaled medium]:
/// x^2 / (1/4 + x^2). A sweep's own light errs with x^2, by 2 % of a slab's transmittance at 1/4 and by 40 % at 1; P1's
/// light has the diffusion limit at any x.
inline double diffusive(double thickness)
{
    constexpr double half = 0.5;
    return thickness * thickness / (half * half + thickness * thickness);
}

/// Coefficients of the cells, without the matrix.
class P1Cells {
public:
    /// Keeps references to `index` and `density`; copies `medium`, but not the arrays to which it points. Throws
    /// InputError if the albedo is out of range.
    P1Cells(const VoxelIndex& index, const std::vector<float>& density, const P1Medium& medium);

    const VoxelIndex& index() const { return index_; }
    const Blocks& blocks() const { return index_.blocks(); }
    const P1Medium& medium() const { return medium_; }
    const std::vector<float>& density() const { return density_; }

    double hbar() const { return hbar_; }
    double face_area(int axis) const { return area_[axis]; }  ///< [hbar^2]
    /// Of overlapping media: the degree, and for each degree the moment that is farthest from 0; delta_f is then 0.
    const DeltaScaling& delta() const { return delta_; }
    ScaledCell scaling(size_t slot) const
    {
        const double w0 = albedo(slot);
        if (!medium_.mixed) return {delta_.albedo(w0), delta_.extinction(w0)};
        const double f = delta_f(slot);
        return {w0 * (1 - f) / (1 - w0 * f), 1 - w0 * f};
    }
    /// Of overlapping media: the mean of their delta_f, weighted by scattering.
    double delta_f(size_t slot) const
    {
        return medium_.mixed ? mean(slot, [](const Part& part) { return part.delta.delta_f; }) : delta_.delta_f;
    }
    /// m_l', the scaled moment of the phase function; of overlapping media their mean, weighted by scaled scattering.
    double moment(int l, size_t slot) const
    {
        if (!medium_.mixed) return delta_.moments[size_t(l)];
        return l == 0 ? 1 : mean(slot, [l](const Part& part) {
                                return part.delta.moments[size_t(l)] * part.delta.scattering();
                            }) / (1 - delta_f(slot));
    }
    /// Phase functions that overlap: 1 without MixedPhases.
    size_t media() const { return medium_.mixed ? parts_.size() : 1; }
    const PhaseFunction& phase(size_t medium) const
    {
        return medium_.mixed ? medium_.mixed->phase[medium] : medium_.phase;
    }
    const DeltaScaling& delta_of(size_t medium) const { return medium_.mixed ? parts_[medium].delta : delta_; }
    /// Share of one of the media in the scaled scattering of a cell.
    double scaled_share(size_t medium, size_t slot) const
    {
        if (!medium_.mixed) return 1;
        return medium_.mixed->share_of(medium, slot) * parts_[medium].delta.scattering() / (1 - delta_f(slot));
    }
    /// g, unscaled; of overlapping media that of the largest size.
    double mean_cosine() const { return mean_cosine_; }
    double mean_cosine(size_t slot) const
    {
        return medium_.mixed ? mean(slot, [](const Part& part) { return part.mean_cosine; }) : mean_cosine_;
    }
    /// Whether scaling() is that of any slot.
    bool uniform() const { return !medium_.tint && !medium_.mixed; }
    double sigma_t(size_t slot) const { return medium_.sigma_t_per_density * density_[slot]; }
    double sigma_tr(size_t slot) const
    {
        constexpr double thinnest = 1 / 3e8;  // of sigma_tr hbar: D / hbar stays below 1e8
        const double limited = medium_.limiter ? (*medium_.limiter)[slot] : 1.0;
        return std::max(sigma_t(slot) * (1 - albedo(slot) * mean_cosine(slot)) / limited, thinnest / hbar_);
    }
    double sigma_a(size_t slot) const { return sigma_t(slot) * (1 - albedo(slot)); }
    /// w0' g' sigma_t', the factor of the uncollided flux in Q1. The factor DEPENDS on the delta scaling, as the
    /// uncollided flux does.
    double q1_factor(size_t slot) const
    {
        const ScaledCell cell = scaling(slot);
        return cell.albedo * moment(1, slot) * cell.extinction * sigma_t(slot);
    }

private:
    /// One of the overlapping media.
    struct Part {
        DeltaScaling delta;
        double mean_cosine;
    };
    /// The mean of value(part) over the overlapping media, weighted by their scattering.
    template<typename Value>
    double mean(size_t slot, const Value& value) const
    {
        double sum = 0;
        for (size_t n = 0; n < parts_.size(); ++n) sum += medium_.mixed->share_of(n, slot) * value(parts_[n]);
        return sum;
    }
    double albedo(size_t slot) const
    {
        return medium_.tint ? std::clamp(medium_.albedo * (*medium_.tint)[slot], 0.0, 1.0) : medium_.albedo;
    }
    const VoxelIndex& index_;
    const std::vector<float>& density_;
    P1Medium medium_;
    double hbar_;
    double area_[3];
    DeltaScaling delta_;
    double mean_cosine_;
    std::vector<Part> parts_;
};

/// The matrix. With g the mean cosine, sigma_tr = sigma_t (1 - w0 g), D = 1/(3 sigma_tr), cells the active voxels with
/// constant coefficients,
///
///     div F + sigma_t (1-w0) phi = Q0,     F = -D grad phi + Q1 / sigma_tr - div t / sigma_tr
///
/// integrated over each cell: phi at centres, F on faces, the harmonic mean of D between two cells (layers in series
/// are then exact), and on an exposed face of weight w (boundary.h), inflow J and correction c the Marshak condition
///
///     F.n = w (phi_b / 2 - 2 J) + c,   with F.n = 2 D (phi - phi_b) / h + a,   a the additive part of F.n
///     =>  F.n = G (phi - 4 J) + (w a / 2 + (2 D / h) c) / (2 D / h + w / 2),   G = 1 / (2/w + h / (2 D)).
///
/// c = 0 and t = 0 are P1; transport sweeps (Kajiya & Von Herzen's equation itself) later supply both.
/// Scaling leaves D and sigma_a as they are, so delta-P1 and plain P1 are this same matrix.
///
/// Units: equations are divided by hbar^2, hbar^3 the cell's volume, so phi keeps its unit and coefficients have none.
/// D / hbar is capped at 1e8: a medium thinner than 3.3e-9 mean free paths a voxel is treated as 3.3e-9.
class P1Operator : public P1Cells {
public:
    /// As P1Cells; keeps a reference to `exposed`, too.
    P1Operator(const VoxelIndex& index, const std::vector<float>& density, const std::vector<ExposedVoxel>& exposed,
               const P1Medium& medium);
    /// The same matrix, without a copy, in the delta scaling of another degree: scaling leaves the matrix as it is.
    P1Operator(const P1Operator&, int degree);
    /// Another medium of equal sigma_tr in the same cells: if the matrix of `like` is built first, the two share links.
    P1Operator(const P1Operator& like, const P1Medium& medium);

    const std::vector<ExposedVoxel>& exposed() const { return exposed_; }
    /// The first call builds the matrix: not by several threads at once.
    const Stencil& stencil() const;
    /// Of what this matrix does not share with another medium's.
    size_t bytes() const { return !matrix_->stencil ? 0 : stencil().bytes() / (matrix_->shares ? 4 : 1); }

    /// q of Q1 / sigma_tr = q U through the upper face of a cell to its active neighbour: the mean of q1_factor() over
    /// that of sigma_tr. Computed as a multiple of the matrix's own coefficient of the face, whose rounding to float
    /// then scales diffusion and this flux alike. Requires that stencil() was called.
    double q1_share(int axis, size_t slot) const;
    /// w of one exposed face (Blocks::Face): the voxel's; on a ground, where the medium ends in a plane, (1 - albedo) /
    /// (1 + albedo).
    double face_weight(const ExposedVoxel& voxel, int face) const;
    /// G of one exposed face, in units of the matrix.
    double conductance(const ExposedVoxel& voxel, int face) const;
    /// Contribution per area of an additive flux a (outward, per area) and a correction c to an exposed face's outflow.
    double boundary_flux(const ExposedVoxel& voxel, int face, double a, double c = 0) const;

private:
    void link(Stencil&) const;
    const std::vector<ExposedVoxel>& exposed_;
    struct Matrix {
        std::shared_ptr<const Matrix> like;  // null: none
        bool shares = false;                 // the links of `like`
        std::optional<Stencil> stencil;
    };
    std::shared_ptr<Matrix> matrix_ = std::make_shared<Matrix>();
};

/// Right-hand side and bookkeeping of one channel. All powers are in units of radiance x (world unit)^2.
struct P1Source {
    explicit P1Source(const P1Operator& of);

    /// through[axis], with 0 where there was none.
    std::vector<double>& through_faces(int axis);

    std::vector<double> rhs;  ///< [power / hbar^2] for each slot
    /// F's additive part [per area], along the axis, through the lower face of each cell that has a neighbour there;
    /// empty: none. Double: in a thin medium diffusion cancels all but F.
    std::array<std::vector<double>, 3> through;
    /// A further part of it, `shared_scale` times arrays that the sources of several channels share; null: none.
    std::shared_ptr<const std::array<std::vector<double>, 3>> shared_through;
    double shared_scale = 1;
    /// Makes `through` the part that other sources may share.
    void share_through();
    /// Outward additive flux per exposed face, six a voxel of exposed(), in power / hbar^2 (without G(phi - 4J)).
    std::vector<std::array<double, 6>> outflow;
    /// Part of `deposited` that each cell absorbs [power / hbar^2]. add_beam() fills it where it has slots() values.
    std::vector<double> beam_absorbed;
    double deposited = 0;      ///< power taken from the (scaled) beams inside the cells
    double first_scatter = 0;  ///< scattered part of `deposited`: the fraction w0'
    double beam_in = 0;        ///< beam power through exposed faces into cells
    double beam_out = 0;       ///< beam power through exposed faces out of cells
    double emitted = 0;        ///< power of emission
    /// Of emission whose light is followed by rays up to its first collision (emitted_light.h): absorbed power, power
    /// out through exposed faces by Blocks::Face, and fluence by slot (null: none). phi is collided light without it.
    double emission_absorbed = 0;
    std::array<double, 6> emission_out{};
    const std::vector<float>* uncollided = nullptr;
    std::array<double, 6> sky_inflow{};  ///< 4 J by Blocks::Face; 4 pi L of a uniform sky
};

/// Uniform sky of radiance L: J = pi L on every exposed face.
void add_sky(const P1Operator&, double radiance, P1Source&);
/// Sky with a cosine-weighted mean radiance J / pi on faces of each orientation, by Blocks::Face.
void add_sky(const P1Operator&, const std::array<double, 6>& radiance, P1Source&);
/// Emission j [radiance / world unit] at each slot, times `factor`: Q0 += 4 pi j.
void add_emission(const P1Operator&, const std::vector<float>& emission, double factor, P1Source&);

/// Power balance of one channel. Powers as in P1Source.
struct P1Budget {
    std::array<double, 6> out{};       ///< diffuse power out through exposed faces, by Blocks::Face
    double to_ground = 0;              ///< of it: net, through faces on the ground
    double sky_in = 0;                 ///< power of the sky on exposed faces
    double absorbed = 0;               ///< of collided light, and of beams and emission at their first collision
    double defect = 0;                 ///< |in - out - absorbed| / in
    double smallest = 0, largest = 0;  ///< of phi and P1Source::uncollided together
    /// Cells with that sum < -1e-7 of its largest value: more negative than rounding and solver tolerance explain.
    int64_t negative = 0;
};

/// Solves for phi [radiance x sr] by multigrid. Overwrites `source.rhs`. One constant added to phi then closes the
/// total power balance exactly (Galerkin correction on constants, of the size of the tolerance).
///
/// The tolerance is relative to ten times the sources without P1Source::through and outflow, if that is less: in a thin
/// medium diffusion cancels them, and what the solver leaves of them must be small against the flux. The constant
/// fluence of a sky is subtracted first, where the sources that are left are smaller: a uniform sky without absorption
/// leaves 0.
///
/// The solver starts from a combination of phi, where it is not empty, and of `alike`: fields that look like the
/// solution less phi, such as those of another channel; 0 at inactive slots (solve/guess.h). The solution depends on
/// them within the tolerance.
using Fields = std::vector<const std::vector<float>*>;
SolveResult solve_p1(const P1Operator&, Multigrid&, P1Source& source, std::vector<double>& phi, const SolveOptions&,
                     const Fields& alike = {});
/// As solve_p1(), by successive over-relaxation (solve/relaxation.h) with relaxation factor `factor`.
SolveResult relax_p1(const P1Operator&, double factor, P1Source& source, std::vector<double>& phi, const SolveOptions&);

/// The residual and the error estimate of `phi` as a solution, as solve_p1() tells them, without a change of phi.
SolveResult judge_p1(const P1Operator&, Multigrid&, P1Source, std::vector<double> phi);

P1Budget budget(const P1Operator&, const P1Source&, const std::vector<double>& phi);

/// F at cell centres, components along the index axes: the mean of the two faces of each axis.
std::array<std::vector<float>, 3> cell_flux(const P1Operator&, const P1Source&, const std::vector<double>& phi);

/// Largest |F| / phi for which the P1 radiance (phi + 3 s.F) / (4 pi) is >= 0 in every direction s.
constexpr double longest_flux = 1.0 / 3;

/// Shortens F to longest_flux x phi where |F| is larger. Returns the number of cells changed. For pictures only: the
/// shortened flux is not conserved.
///
/// P1's flux follows its source locally, F = ... + w0' g' / (1 - w0' g') E T' s, also where light enters a cloud and
/// little has been scattered yet. With the sun behind the viewer at g = 0.85 this flux removes six sevenths of the
/// picture (tests/pipelines). Deep inside a cloud |F| is far below phi / 3.
int64_t limit_flux(const P1Operator&, const std::vector<double>& phi, std::array<std::vector<float>, 3>& flux);

}  // namespace vdbcloud
