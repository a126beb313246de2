// Solutions of the P1 equations.
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/block_rows.h"
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/solve/guess.h"
#include "vdbcloud/solve/parallel.h"
#include "vdbcloud/solve/relaxation.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

void add_constant(const P1Operator& p1, double constant, std::vector<double>& phi)
{
    if (constant != 0) each_active(p1.blocks(), [&](size_t slot) { phi[slot] += constant; });
}

/// Sum over all slots, in a fixed order.
template<typename T>
double total(const Blocks& blocks, const T* values)
{
    return ordered_sum(blocks.count(), [&](size_t block) {
        eight::Doubles sums{};
        for (size_t n = 0; n < Blocks::size; n += 8)
            sums += eight::as<double>(eight::load(values + block * Blocks::size + n));
        return eight::sum(sums);
    });
}

/// Adds to phi the constant that closes the total power balance exactly.
void close_balance(const P1Operator& p1, const std::vector<double>& residual, std::vector<double>& phi)
{
    const Blocks& blocks = p1.blocks();
    const double left = total(blocks, residual.data()), loss = total(blocks, p1.stencil().extra.data());
    if (loss > 0) add_constant(p1, left / loss, phi);
}

/// Of the tolerance's norm over that of the sources without additive flux: clouds of thick voxels take no iteration
/// more.
constexpr double norm_slack = 10;

/// What the additive flux through the faces of an axis, 0 where there is none, brings into the voxels of a block, times
/// `area`: taken from `rhs`.
template<int axis>
VDBCLOUD_INLINE void take_flux(const BlockRows& rows, const double* through, double area, double* rhs)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const int row = x * 64 + y * 8;
            const eight::Doubles in = rows.at<axis, 0>(through, x, y) - rows.at<axis, 1>(through, x, y);
            eight::store(rhs + row, eight::load(rhs + row) - in * eight::all(area));
        }
}

VDBCLOUD_CLONES void take_flux(int axis, const BlockRows& rows, const double* through, double area, double* rhs)
{
    switch (axis) {
    case 0: return take_flux<0>(rows, through, area, rhs);
    case 1: return take_flux<1>(rows, through, area, rhs);
    default: return take_flux<2>(rows, through, area, rhs);
    }
}

/// The norm of the right-hand side without its additive flux, times norm_slack; 0: no such flux.
double norm_without_additive(const P1Operator& p1, const P1Source& source)
{
    const Blocks& blocks = p1.blocks();
    struct Part {
        int axis;
        const double* through;
        double area;
    };
    std::vector<Part> parts;
    for (int a = 0; a < 3; ++a) {
        const double area = p1.face_area(a);
        if (!source.through[size_t(a)].empty()) parts.push_back({a, source.through[size_t(a)].data(), area});
        if (source.shared_through && !(*source.shared_through)[size_t(a)].empty())
            parts.push_back({a, (*source.shared_through)[size_t(a)].data(), area * source.shared_scale});
    }
    if (parts.empty()) return 0;
    const std::vector<ExposedVoxel>& exposed = p1.exposed();  // by slot
    const double square = ordered_sum(blocks.count(), [&](size_t block) {
        const size_t first = block * Blocks::size;
        alignas(64) double rhs[Blocks::size];
        std::copy_n(source.rhs.data() + first, Blocks::size, rhs);
        const BlockRows rows(blocks, block);
        for (const Part& part : parts) take_flux(part.axis, rows, part.through, part.area, rhs);
        const auto from = std::lower_bound(exposed.begin(), exposed.end(), first,
                                           [](const ExposedVoxel& voxel, size_t slot) { return voxel.slot < slot; });
        for (auto voxel = from; voxel != exposed.end() && voxel->slot < first + Blocks::size; ++voxel)
            for (const double outflow : source.outflow[size_t(voxel - exposed.begin())])
                rhs[voxel->slot - first] += outflow;
        eight::Doubles squares{};
        for (int n = 0; n < int(Blocks::size); n += 8) {
            const eight::Doubles row = eight::load(rhs + n);
            squares += row * row;
        }
        return eight::sum(squares);
    });
    return norm_slack * std::sqrt(square);
}

/// sigma_a hbar and the conductances of the exposed faces: A applied to a fluence of 1 everywhere, in double.
std::vector<double> losses(const P1Operator& p1)
{
    std::vector<double> loss(p1.blocks().slots(), 0.0);
    each_active(p1.blocks(), [&](size_t slot) { loss[slot] = p1.sigma_a(slot) * p1.hbar(); });
    for (const ExposedVoxel& voxel : p1.exposed())
        for (int face = 0; face < 6; ++face)
            if (voxel.faces >> face & 1) loss[voxel.slot] += p1.conductance(voxel, face);
    return loss;
}

/// The mean of P1Source::sky_inflow over the exposed faces, by conductance.
double mean_inflow(const P1Operator& p1, const P1Source& source)
{
    const auto& all = source.sky_inflow;
    if (std::all_of(all.begin(), all.end(), [&](double j) { return j == all[0]; })) return all[0];  // without rounding
    double sum = 0, weights = 0;
    for (const ExposedVoxel& voxel : p1.exposed())
        for (int face = 0; face < 6; ++face) {
            if (!(voxel.faces >> face & 1)) continue;
            const double g = p1.conductance(voxel, face);
            sum += g * source.sky_inflow[face];
            weights += g;
        }
    return weights > 0 ? sum / weights : 0;
}

/// The fluence less the constant of a sky, as the unknown: fluxes are differences of fluences, and what the solver
/// leaves of the constant would be large against them. Changes rhs and phi; returns the constant to add to the
/// solution, 0 where the right-hand side would not be smaller without it.
double take_constant(const P1Operator& p1, P1Source& source, std::vector<double>& phi)
{
    constexpr double rounding = 2e-15;  // of a sum of six conductances
    const Blocks& blocks = p1.blocks();
    const double constant = mean_inflow(p1, source);
    if (constant == 0) return 0;
    std::vector<double> rhs = losses(p1);
    each_active(blocks, [&](size_t slot) {
        const double less = source.rhs[slot] - constant * rhs[slot];
        rhs[slot] = std::abs(less) > rounding * std::abs(source.rhs[slot]) ? less : 0.0;
    });
    const auto square = [&](const std::vector<double>& v) { return dot(blocks, v.data(), v.data()); };
    if (!(square(rhs) < square(source.rhs))) return 0;
    source.rhs.swap(rhs);
    if (!phi.empty()) each_active(blocks, [&](size_t slot) { phi[slot] -= constant; });
    return constant;
}

}  // namespace

SolveResult solve_p1(const P1Operator& p1, Multigrid& multigrid, P1Source& source, std::vector<double>& phi,
                     const SolveOptions& options, const Fields& alike)
{
    SolveOptions scaled = options;
    const double constant = take_constant(p1, source, phi);
    scaled.norm = norm_without_additive(p1, source);
    if (!alike.empty() || !phi.empty()) improve_guess(p1.stencil(), source.rhs, alike, phi);
    const SolveResult result = conjugate_gradient(p1.stencil(), multigrid, source.rhs, phi, scaled);
    close_balance(p1, source.rhs, phi);
    add_constant(p1, constant, phi);
    return result;
}

SolveResult relax_p1(const P1Operator& p1, double factor, P1Source& source, std::vector<double>& phi,
                     const SolveOptions& options)
{
    const double constant = take_constant(p1, source, phi);
    const SolveResult result = relax(p1.stencil(), factor, source.rhs, phi, options);
    if (result.converged) close_balance(p1, source.rhs, phi);
    add_constant(p1, constant, phi);
    return result;
}

SolveResult judge_p1(const P1Operator& p1, Multigrid& multigrid, P1Source source, std::vector<double> phi)
{
    SolveOptions none;
    take_constant(p1, source, phi);
    none.norm = norm_without_additive(p1, source);
    none.max_iterations = 0;
    return conjugate_gradient(p1.stencil(), multigrid, source.rhs, phi, none);
}

}  // namespace vdbcloud
