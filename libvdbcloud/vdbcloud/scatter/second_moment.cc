#include "vdbcloud/scatter/second_moment.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/release.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/first_scattering.h"
#include "vdbcloud/scatter/mixing.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace vdbcloud {

namespace {

Vec3d index_components(const VoxelIndex& index, const Vec3d& world)
{
    return {world.dot(index.axis(0)), world.dot(index.axis(1)), world.dot(index.axis(2))};
}

}  // namespace

double tolerance_between(const ClosureOptions& closure, const SolveOptions& options, double change)
{
    return std::max(options.tolerance, closure.solve_share * std::min(change, 1.0));
}

double tolerance_before(const ClosureOptions& closure, const SolveOptions& options)
{
    return tolerance_between(closure, options, 1);
}

size_t mixing_bytes(size_t slots, double g) { return Mixing::bytes(slots, mixed_arrays(g), mixing_depth(g)); }

std::vector<ExposedVoxel> closure_exposed(const P1Cells& p1, std::vector<ExposedVoxel> exposed)
{
    for (ExposedVoxel& voxel : exposed)
        for (int a = 0; a < 3; ++a) {
            const double x = p1.sigma_tr(voxel.slot) * p1.index().spacing()[a], w = voxel.weight[a];
            voxel.weight[a] = float(w + (1 - w) * x * x / (1 + x * x));
        }
    return exposed;
}

OrdinateFrame frame_of(const VoxelIndex& index, const std::array<bool, 3>& periodic, const Vec3d& up)
{
    if (periodic[0] + periodic[1] + periodic[2] == 2) return {!periodic[0] ? 0 : !periodic[1] ? 1 : 2, true};
    int nearest = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(index.axis(a).dot(up)) > std::abs(index.axis(nearest).dot(up))) nearest = a;
    return {nearest, false};
}

std::vector<SweepFace> faces_of(const std::vector<ExposedVoxel>& exposed)
{
    std::vector<SweepFace> faces;
    for (const ExposedVoxel& voxel : exposed)
        for (int face = 0; face < 6; ++face)
            if (voxel.faces >> face & 1) faces.push_back({voxel.slot, uint8_t(face)});
    return faces;
}

SecondMoment::SecondMoment(const P1Operator& p1, const ClosureOptions& options, const OrdinateFrame& frame,
                           TransportSweep* transport, const SecondMoment* like)
    : p1_(p1), o_(options),
      own_(transport ? nullptr : std::make_unique<TransportSweep>(p1.index(), faces_of(p1.exposed()))),
      transport_(transport ? *transport : *own_)
{
    if (o_.degree < 1 || o_.degree > 7) throw InputError("degree " + std::to_string(o_.degree) + ": expected 1 to 7");
    // t needs moments of degree 2, which must be exact only for radiance that P1 treats as isotropic.
    const int carried = std::max(o_.degree, 2);
    ordinates_ = ordinates(o_.kind, o_.directions, o_.degree, frame.polar, frame.layered);
    if (p1.delta().degree != o_.degree)
        throw InputError("degree " + std::to_string(o_.degree) + " of the sweeps: expected that of the P1 operator, " +
                         std::to_string(p1.delta().degree));
    terms_ = harmonic_count(p1.delta().last_degree());
    set_.source_terms = terms_;
    set_.moment_terms = harmonic_count(carried);
    std::vector<double> y(size_t(set_.moment_terms));
    for (size_t m = 0; m < ordinates_.count(); ++m) {
        evaluate_harmonics(carried, ordinates_.direction[m], y.data());
        set_.direction.push_back(ordinates_.direction[m]);
        set_.weight.push_back(float(ordinates_.weight[m]));
        set_.source_basis.insert(set_.source_basis.end(), y.begin(), y.begin() + terms_);
        set_.moment_basis.insert(set_.moment_basis.end(), y.begin(), y.end());
    }
    const Blocks& blocks = p1.blocks();
    for (const ExposedVoxel& voxel : p1.exposed()) faces_ += size_t(__builtin_popcount(voxel.faces));
    std::vector<float> sigma(blocks.slots(), 0.0f);
    each_active(blocks, [&](size_t slot) { sigma[slot] = float(p1.scaling(slot).extinction * p1.sigma_t(slot)); });
    owns_sigma_ = !like || *like->sigma_ != sigma;
    sigma_ = owns_sigma_ ? std::make_shared<const std::vector<float>>(std::move(sigma)) : like->sigma_;
    source_.resize(size_t(terms_));
    uncollided_.assign(size_t(terms_), std::vector<float>(blocks.slots(), 0.0f));
    swept_.moments.resize(size_t(set_.moment_terms));
    for (size_t k = 0; k < std::max(size_t(terms_), mixed_arrays(p1.mean_cosine())); ++k)
        swept_.moments[k].assign(blocks.slots(), 0.0f);  // the sweep makes the others
}

void SecondMoment::add_beam_moments(const Light& light, const std::vector<float>& fluence, double strength,
                                    std::vector<std::vector<float>>& moments) const
{
    const VoxelIndex& index = p1_.index();
    const int terms = std::min(terms_, int(moments.size()));
    each_active(index.blocks(), [&](size_t slot) {
        const Vec3i v = index.blocks().voxel(slot);
        const Sight sight = light->towards(index.world(Vec3d(v.x(), v.y(), v.z())));
        double y[64] = {};
        if (sight.distance > 0)
            evaluate_harmonics(o_.degree, index_components(index, -sight.direction), y);
        else
            y[0] = std::sqrt(1 / (4 * pi));
        for (int k = 0; k < terms; ++k) moments[size_t(k)][slot] += float(strength * fluence[slot] * y[k]);
    });
}

void SecondMoment::add_uncollided(const Light& light, const std::vector<float>& fluence, double strength,
                                  const std::optional<Vec3d>& disc)
{
    add_beam_moments(light, fluence, strength, uncollided_);
    const auto towards = disc ? disc : light->common_direction();
    for (size_t n = 0; towards && n < p1_.media(); ++n) {
        if (p1_.phase(n).mean_cosine() == 0) continue;
        std::vector<float>& first = first_scattered(n, -index_components(p1_.index(), *towards));
        each_active(p1_.blocks(), [&](size_t slot) {
            first[slot] += float(p1_.scaling(slot).albedo * p1_.scaled_share(n, slot) * strength * fluence[slot]);
        });
    }
}

/// The source's term of light that a sun sends along `along` and a medium scatters, beyond the expansion.
std::vector<float>& SecondMoment::first_scattered(size_t medium, const Vec3d& along)
{
    const std::pair wanted{medium, along};
    for (size_t k = 0; k < suns_.size(); ++k)
        if (suns_[k] == wanted) return source_[size_t(terms_) + k];
    suns_.push_back(wanted);
    const auto value = first_scattering(ordinates_, p1_.phase(medium), p1_.delta_of(medium), along);
    const auto expanded = expanded_scattering(ordinates_, p1_.delta_of(medium), along);
    const size_t before = size_t(set_.source_terms);
    std::vector<float> basis;
    for (size_t m = 0; m < ordinates_.count(); ++m) {
        const auto row = set_.source_basis.begin() + std::ptrdiff_t(m * before);
        basis.insert(basis.end(), row, row + std::ptrdiff_t(before));
        basis.push_back(float(value[m] - expanded[m]));
    }
    set_.source_basis = std::move(basis);
    ++set_.source_terms;
    return source_.emplace_back(p1_.blocks().slots(), 0.0f);
}

void SecondMoment::add_uncollided(const std::vector<std::vector<float>>& moments)
{
    for (size_t k = 0; k < std::min(moments.size(), uncollided_.size()); ++k)
        each_active(p1_.blocks(), [&](size_t slot) { uncollided_[k][slot] += moments[k][slot]; });
}

void SecondMoment::start_with(const Light& light, const std::vector<float>& fluence, double strength)
{
    add_beam_moments(light, fluence, strength, swept_.moments);
}

void SecondMoment::start_with_flux(const std::array<std::vector<float>, 3>& flux, double factor)
{
    if (!takes_flux()) return;
    const double scale = factor * std::sqrt(3 / (4 * pi));
    const int of_axis[3] = {harmonic(1, 1), harmonic(1, -1), harmonic(1, 0)};
    for (int a = 0; a < 3; ++a)
        each_active(p1_.blocks(),
                    [&](size_t slot) { swept_.moments[size_t(of_axis[a])][slot] += float(scale * flux[a][slot]); });
}

void SecondMoment::start_with_moments(const std::vector<std::vector<float>>& moments, const std::vector<char>& known)
{
    for (size_t k = 1; k < size_t(terms_); ++k)
        each_active(p1_.blocks(), [&](size_t slot) {
            if (known[slot]) swept_.moments[k][slot] = k < moments.size() ? moments[k][slot] : 0.0f;
        });
}

void SecondMoment::add_emission(const std::vector<float>& emission, double factor)
{
    emission_.resize(1, std::vector<float>(p1_.blocks().slots(), 0.0f));
    each_active(p1_.blocks(), [&](size_t slot) {
        emission_[0][slot] += float(factor * emission[slot] * std::sqrt(4 * pi) / (*sigma_)[slot]);
    });
}

void SecondMoment::scatter_less(const std::vector<float>& light)
{
    if (less_.empty()) less_.assign(p1_.blocks().slots(), 0.0f);
    each_active(p1_.blocks(),
                [&](size_t slot) { less_[slot] += float(light[slot] * std::sqrt(4 * pi) / (*sigma_)[slot]); });
}

void SecondMoment::take_phi(const std::vector<double>& phi)
{
    each_active(p1_.blocks(), [&](size_t slot) { swept_.moments[0][slot] = float(phi[slot] / std::sqrt(4 * pi)); });
}

double SecondMoment::fluence_of(float moment) { return std::sqrt(4 * pi) * double(moment); }

/// The next moment of degree 0: that of phi_L, `swept`, and the excess of phi over phi_L.
void SecondMoment::take_excess(const std::vector<float>& swept, const std::vector<double>& excess)
{
    each_active(p1_.blocks(), [&](size_t slot) {
        swept_.moments[0][slot] = float((fluence_of(swept[slot]) + excess[slot]) / std::sqrt(4 * pi));
    });
}

void SecondMoment::build_source()
{
    for (int k = 0; k < terms_; ++k) source_[size_t(k)].resize(p1_.blocks().slots());
    each_active(p1_.blocks(), [&](size_t slot) {
        const double albedo = p1_.scaling(slot).albedo;
        for (int l = 0, k = 0; k < terms_; ++l) {
            const double scattered = albedo * p1_.moment(l, slot);
            for (const int end = harmonic_count(l); k < end; ++k)
                source_[size_t(k)][slot] =
                    float(scattered * (double(swept_.moments[size_t(k)][slot]) + uncollided_[size_t(k)][slot]));
        }
        if (!less_.empty()) source_[0][slot] -= less_[slot];
    });
}

/// Frees what build_source() makes.
void SecondMoment::drop_source()
{
    for (int k = 0; k < terms_; ++k) release(source_[size_t(k)]);
}

/// Frees what neither the next source nor the result takes.
void SecondMoment::drop_moments()
{
    for (size_t k = size_t(harmonic_count(o_.degree)); k < swept_.moments.size(); ++k) release(swept_.moments[k]);
}

size_t SecondMoment::bytes() const
{
    const size_t slots = p1_.blocks().slots();
    return 4 * slots *
               (size_t(2 * terms_) + suns_.size() + size_t(set_.moment_terms) + (owns_sigma_ ? 1 : 0) +
                (less_.empty() ? 0 : 1) + (emission_.empty() ? 0 : 1 + size_t(set_.moment_terms))) +
           mixing_bytes(slots, p1_.mean_cosine()) + faces_ * (sizeof(SweepFace) + sizeof(FaceTally));
}

}  // namespace vdbcloud
