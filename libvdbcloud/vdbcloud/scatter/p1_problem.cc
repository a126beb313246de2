#include "vdbcloud/scatter/p1_problem.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/scatter/active_slots.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// Sum over active slots, in a fixed order.
template<typename F>
double total(const Blocks& blocks, const F& f)
{
    std::vector<double> part(blocks.count(), 0.0);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            if (blocks.active(slot)) part[b] += f(slot);
    });
    double sum = 0;
    for (double p : part) sum += p;
    return sum;
}

DeltaScaling scaling_of(const P1Medium& medium, const PhaseFunction& phase)
{
    return medium.delta ? delta_scaling(phase, medium.degree) : no_scaling(phase, medium.degree);
}

}  // namespace

P1Cells::P1Cells(const VoxelIndex& index, const std::vector<float>& density, const P1Medium& medium)
    : index_(index), density_(density), medium_(medium), delta_(scaling_of(medium, medium.phase)),
      mean_cosine_(medium.phase.mean_cosine())
{
    if (medium.mixed) {
        for (const PhaseFunction& phase : medium.mixed->phase)
            parts_.push_back({scaling_of(medium, phase), phase.mean_cosine()});
        std::vector<DeltaScaling> scalings;
        for (const Part& part : parts_) {
            scalings.push_back(part.delta);
            if (std::abs(part.mean_cosine) > std::abs(mean_cosine_)) mean_cosine_ = part.mean_cosine;
        }
        delta_ = largest_of(scalings);
    }
    if (!(medium.albedo >= 0 && medium.albedo <= 1))
        throw InputError("albedo = " + std::to_string(medium.albedo) + ": expected 0 to 1");
    const Vec3d& h = index.spacing();
    hbar_ = std::cbrt(h[0] * h[1] * h[2]);
    for (int a = 0; a < 3; ++a) area_[a] = hbar_ / h[a];
}

P1Operator::P1Operator(const VoxelIndex& index, const std::vector<float>& density,
                       const std::vector<ExposedVoxel>& exposed, const P1Medium& medium)
    : P1Cells(index, density, medium), exposed_(exposed)
{
}

void P1Operator::link(Stencil& stencil) const
{
    const P1Closure closure = p1_closure();
    each_active(blocks(), [&](size_t slot) {
        const double own = sigma_tr(slot);
        for (int a = 0; a < 3; ++a) {
            const size_t to = beside(blocks(), slot, 2 * a + 1);
            if (!blocks().active(to) || to == slot) continue;
            const double d = closure.divergence * closure.gradient * 2 / (own + sigma_tr(to));  // harmonic mean of D
            stencil.face[a][slot] = float(d / index().spacing()[a] * face_area(a));
        }
    });
}

const Stencil& P1Operator::stencil() const
{
    if (matrix_->stencil) return *matrix_->stencil;
    matrix_->shares = matrix_->like && matrix_->like->stencil;
    if (matrix_->shares)
        matrix_->stencil.emplace(*matrix_->like->stencil);
    else
        link(matrix_->stencil.emplace(blocks()));
    std::vector<float>& extra = matrix_->stencil->extra;
    each_active(blocks(), [&](size_t slot) { extra[slot] = float(sigma_a(slot) * hbar()); });
    for (const ExposedVoxel& voxel : exposed_)
        for (int face = 0; face < 6; ++face)
            if (voxel.faces >> face & 1) extra[voxel.slot] += float(conductance(voxel, face));
    return *matrix_->stencil;
}

namespace {

P1Medium of_degree(P1Medium medium, int degree)
{
    medium.degree = degree;
    return medium;
}

}  // namespace

P1Operator::P1Operator(const P1Operator& of, int degree)
    : P1Cells(of.index(), of.density(), of_degree(of.medium(), degree)), exposed_(of.exposed_), matrix_(of.matrix_)
{
}

P1Operator::P1Operator(const P1Operator& like, const P1Medium& medium)
    : P1Cells(like.index(), like.density(), medium), exposed_(like.exposed_)
{
    matrix_->like = like.matrix_;
}

double P1Operator::q1_share(int axis, size_t slot) const
{
    const size_t above = blocks().neighbour(slot, 2 * axis + 1);
    const double face = stencil().face[axis][slot];
    // No diffusion crosses a period of one voxel; in a medium beyond the range of float it is too small to matter.
    if (face < std::numeric_limits<float>::min())
        return (q1_factor(slot) + q1_factor(above)) / (sigma_tr(slot) + sigma_tr(above));
    const P1Closure closure = p1_closure();
    return (q1_factor(slot) + q1_factor(above)) / (2 * closure.divergence * closure.gradient) *
           index().spacing()[axis] / face_area(axis) * face;
}

double P1Operator::face_weight(const ExposedVoxel& voxel, int face) const
{
    if (!(voxel.grounded >> face & 1)) return voxel.weight[face / 2];
    return (1 - medium().ground_albedo) / (1 + medium().ground_albedo);
}

double P1Operator::conductance(const ExposedVoxel& voxel, int face) const
{
    const int axis = face / 2;
    const double w = face_weight(voxel, face), resistance = 1.5 * sigma_tr(voxel.slot) * index().spacing()[axis];
    return w / (2 + w * resistance) * face_area(axis);
}

double P1Operator::boundary_flux(const ExposedVoxel& voxel, int face, double a, double c) const
{
    const double w = face_weight(voxel, face), k = 2 / (3 * sigma_tr(voxel.slot) * index().spacing()[face / 2]);
    return (w * a / 2 + k * c) / (k + w / 2);
}

P1Source::P1Source(const P1Operator& of) : rhs(of.blocks().slots(), 0.0), outflow(of.exposed().size()) {}

void P1Source::share_through()
{
    shared_through = std::make_shared<std::array<std::vector<double>, 3>>(std::move(through));
    through = {};
    shared_scale = 1;
}

std::vector<double>& P1Source::through_faces(int axis)
{
    auto& faces = through[size_t(axis)];
    if (faces.empty()) faces.assign(rhs.size(), 0.0);
    return faces;
}

void add_sky(const P1Operator& p1, double radiance, P1Source& source)
{
    std::array<double, 6> all;
    all.fill(radiance);
    add_sky(p1, all, source);
}

void add_sky(const P1Operator& p1, const std::array<double, 6>& radiance, P1Source& source)
{
    for (int face = 0; face < 6; ++face) source.sky_inflow[face] += 4 * pi * radiance[face];
    for (const ExposedVoxel& voxel : p1.exposed())
        for (int face = 0; face < 6; ++face)
            if (voxel.faces >> face & 1)
                source.rhs[voxel.slot] += p1.conductance(voxel, face) * 4 * pi * radiance[face];
}

void add_emission(const P1Operator& p1, const std::vector<float>& emission, double factor, P1Source& source)
{
    const double scale = 4 * pi * factor * p1.hbar();
    each_active(p1.blocks(), [&](size_t slot) { source.rhs[slot] += scale * emission[slot]; });
    source.emitted +=
        scale * p1.hbar() * p1.hbar() * total(p1.blocks(), [&](size_t slot) { return double(emission[slot]); });
}

P1Budget budget(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi)
{
    const Blocks& blocks = p1.blocks();
    const double unit = p1.hbar() * p1.hbar();
    P1Budget b;
    double gross_sky = 0;
    for (size_t k = 0; k < p1.exposed().size(); ++k) {
        const ExposedVoxel& voxel = p1.exposed()[k];
        for (int face = 0; face < 6; ++face) {
            if (!(voxel.faces >> face & 1)) continue;
            const int a = face / 2;
            const double inflow = voxel.weight[a] * p1.face_area(a) * source.sky_inflow[face] / 4;
            const double out = unit * (p1.conductance(voxel, face) * (phi[voxel.slot] - source.sky_inflow[face]) +
                                       double(source.outflow[k][face]) + inflow);
            b.out[face] += out;
            if (voxel.grounded >> face & 1) b.to_ground += out;
            gross_sky += unit * inflow;
        }
    }
    for (size_t face = 0; face < 6; ++face) b.out[face] += source.emission_out[face];
    b.sky_in = gross_sky;
    b.absorbed = source.deposited - source.first_scatter + source.emission_absorbed +
                 unit * total(blocks, [&](size_t slot) { return p1.sigma_a(slot) * p1.hbar() * phi[slot]; });
    const double in = source.deposited + source.emitted + b.sky_in;
    double out = b.absorbed;
    for (double o : b.out) out += o;
    b.defect = in != 0 ? std::abs(in - out) / std::abs(in) : 0.0;

    const auto fluence = [&](size_t slot) {
        return phi[slot] + (source.uncollided ? (*source.uncollided)[slot] : 0.0f);
    };
    bool first = true;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) continue;
        b.smallest = first ? fluence(slot) : std::min(b.smallest, fluence(slot));
        b.largest = first ? fluence(slot) : std::max(b.largest, fluence(slot));
        first = false;
    }
    const double rounding = 1e-7 * std::max(std::abs(b.largest), std::abs(b.smallest));
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        b.negative += blocks.active(slot) && fluence(slot) < -rounding;
    return b;
}

std::array<std::vector<float>, 3> cell_flux(const P1Operator& p1, const P1Source& source,
                                            const std::vector<double>& phi)
{
    const Blocks& blocks = p1.blocks();
    std::array<std::vector<float>, 3> flux;
    for (int a = 0; a < 3; ++a) {
        const std::vector<double>& through = source.through[a];
        const double* shared = source.shared_through && !(*source.shared_through)[a].empty()
                                   ? (*source.shared_through)[a].data()
                                   : nullptr;
        flux[a].assign(blocks.slots(), 0.0f);
        each_active(blocks, [&](size_t slot) {
            const size_t lower = beside(blocks, slot, 2 * a), upper = beside(blocks, slot, 2 * a + 1);
            double f = 0;
            if (blocks.active(lower)) f += double(p1.stencil().face[a][lower]) * (phi[lower] - phi[slot]);
            if (blocks.active(upper)) f += double(p1.stencil().face[a][slot]) * (phi[slot] - phi[upper]);
            f /= p1.face_area(a);
            if (!through.empty()) f += through[slot] + (blocks.active(upper) ? through[upper] : 0.0);
            if (shared) f += source.shared_scale * (shared[slot] + (blocks.active(upper) ? shared[upper] : 0.0));
            flux[a][slot] = float(f / 2);
        });
    }
    for (size_t k = 0; k < p1.exposed().size(); ++k)
        for (int face = 0; face < 6; ++face) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            if (!(voxel.faces >> face & 1)) continue;
            const int a = face / 2;
            const double free = p1.conductance(voxel, face) * (phi[voxel.slot] - source.sky_inflow[face]);
            const double out = (free + source.outflow[k][face]) / p1.face_area(a);
            flux[a][voxel.slot] += float((face % 2 ? out : -out) / 2);
        }
    return flux;
}

int64_t limit_flux(const P1Operator& p1, const std::vector<double>& phi, std::array<std::vector<float>, 3>& flux)
{
    std::vector<int64_t> limited(p1.blocks().count(), 0);
    each_active(p1.blocks(), [&](size_t slot) {
        double square = 0;
        for (int a = 0; a < 3; ++a) square += double(flux[a][slot]) * flux[a][slot];
        const double longest = longest_flux * std::max(phi[slot], 0.0), length = std::sqrt(square);
        if (length <= longest) return;
        for (int a = 0; a < 3; ++a) flux[a][slot] = float(flux[a][slot] * (longest / length));
        ++limited[slot / Blocks::size];
    });
    int64_t count = 0;
    for (int64_t n : limited) count += n;
    return count;
}

}  // namespace vdbcloud
