#include "vdbcloud/solve/conjugate_gradient.h"

#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

struct Sums {
    double rz, apz;
};

/// r . z and Ap . z in one pass, ordered.
Sums sums_with(const Blocks& blocks, const std::vector<double>& r, const std::vector<double>& ap, const std::vector<float>& z)
{
    std::vector<Sums> terms(blocks.count());
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block) {
            double rz[8] = {}, apz[8] = {};
            for (size_t row = block * 512; row < block * 512 + 512; row += 8)
                for (int k = 0; k < 8; ++k) {
                    rz[k] += r[row + k] * double(z[row + k]);
                    apz[k] += ap[row + k] * double(z[row + k]);
                }
            Sums total{0, 0};
            for (int k = 0; k < 8; ++k) total = {total.rz + rz[k], total.apz + apz[k]};
            terms[block] = total;
        }
    });
    Sums all{0, 0};
    for (const Sums& term : terms) all = {all.rz + term.rz, all.apz + term.apz};
    return all;
}

/// x += alpha p, r -= alpha Ap; returns r . r.
double advance(const Blocks& blocks, double alpha, const std::vector<double>& p, const std::vector<double>& ap,
               std::vector<double>& x, std::vector<double>& r)
{
    return ordered_sum(blocks.count(), [&](size_t block) {
        double rr[8] = {};
        for (size_t row = block * 512; row < block * 512 + 512; row += 8)
            for (int k = 0; k < 8; ++k) {
                x[row + k] += alpha * p[row + k];
                r[row + k] -= alpha * ap[row + k];
                rr[k] += r[row + k] * r[row + k];
            }
        double total = 0;
        for (double lane : rr) total += lane;
        return total;
    });
}

/// p = z + beta p.
void add_direction(const Blocks& blocks, const std::vector<float>& z, double beta, std::vector<double>& p)
{
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t slot = first * 512; slot < last * 512; ++slot) p[slot] = double(z[slot]) + beta * p[slot];
    });
}

void clear_inactive(const Blocks& blocks, std::vector<double>& v)
{
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t slot = first * 512; slot < last * 512; ++slot)
            if (!blocks.active(slot)) v[slot] = 0;
    });
}

/// Removes the mean over the active voxels, and whatever the others hold.
void remove_mean(const Blocks& blocks, std::vector<double>& v)
{
    clear_inactive(blocks, v);
    const double mean = sum(blocks, v.data()) / double(std::max<size_t>(1, blocks.active_count()));
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) v[slot] -= mean;
}

}  // namespace

SolveResult conjugate_gradient(const Stencil& a, Multigrid& multigrid, std::vector<double>& b, std::vector<double>& x,
                               const SolveOptions& options)
{
    const Blocks& blocks = *a.blocks;
    const bool singular = std::all_of(a.extra.begin(), a.extra.end(), [](float e) { return e == 0; });
    if (singular) remove_mean(blocks, b);
    std::vector<double>& r = b;
    const double norm = std::sqrt(dot(blocks, b.data(), b.data()));
    std::vector<double> p(blocks.slots(), 0.0), ap(blocks.slots(), 0.0);
    double energy = 0, rr = norm * norm, alpha = 0, rz_before = 0;
    if (x.empty())
        x.assign(blocks.slots(), 0.0);
    else {
        clear_inactive(blocks, x);
        energy = apply(a, x, ap);
        rr = advance(blocks, 1.0, p, ap, p, r);  // r = b - A x; p is 0 and stays so
    }

    SolveResult result;
    while (true) {
        result.residual = norm > 0 ? std::sqrt(rr) / norm : 0.0;
        result.history.push_back(result.residual);
        report(options.progress, std::min(1.0, std::log(result.residual) / std::log(options.tolerance)));
        if (result.residual == 0) result.converged = true;
        if (result.converged || !std::isfinite(result.residual)) break;

        const std::vector<float>& z = multigrid.cycle(r);
        const auto [rz, apz] = sums_with(blocks, r, ap, z);
        result.error = energy > 0 ? std::sqrt(std::abs(rz) / energy) : 1.0;
        result.converged = result.residual <= options.tolerance && result.error <= options.tolerance;
        if (result.converged || result.iterations >= options.max_iterations || !(rz > 0)) break;

        // beta by Polak and Ribiere, z . (r - r_before) / rz_before: rounding in the cycle makes it slightly
        // unsymmetric, which this quotient forgives.
        const double beta = rz_before > 0 ? -alpha * apz / rz_before : 0.0;
        add_direction(blocks, z, beta, p);
        if (singular) remove_mean(blocks, p);
        alpha = rz / apply(a, p, ap);
        rr = advance(blocks, alpha, p, ap, x, r);
        energy += alpha * rz;
        rz_before = rz;
        ++result.iterations;
    }
    if (singular) remove_mean(blocks, x);
    clear_inactive(blocks, x);
    return result;
}

}  // namespace vdbcloud
