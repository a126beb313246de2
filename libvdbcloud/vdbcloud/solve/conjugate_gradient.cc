#include "vdbcloud/solve/conjugate_gradient.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr double least_norm = 1e-9;  // of SolveOptions::norm over that of b

VDBCLOUD_CLONES double advance_block(double alpha, const float* p, const double* ap, double* x, double* r)
{
    const Doubles step = all(alpha);
    Doubles rr{};
    for (int row = 0; row < 512; row += 8) {
        store(x + row, load(x + row) + step * as<double>(load(p + row)));
        const Doubles left = load(r + row) - step * load(ap + row);
        store(r + row, left);
        rr += left * left;
    }
    return sum(rr);
}

/// x += alpha p, r -= alpha Ap; returns r . r.
double advance(const Blocks& blocks, double alpha, const std::vector<float>& p, const std::vector<double>& ap,
               std::vector<double>& x, std::vector<double>& r)
{
    return ordered_sum(blocks.count(), [&](size_t block) {
        const size_t at = block * 512;
        return advance_block(alpha, p.data() + at, ap.data() + at, x.data() + at, r.data() + at);
    });
}

VDBCLOUD_CLONES void add_block(const float* z, float beta, float* p)
{
    for (int row = 0; row < 512; row += 8) store(p + row, load(z + row) + all(beta) * load(p + row));
}

/// p = z + beta p.
void add_direction(const Blocks& blocks, const std::vector<float>& z, float beta, std::vector<float>& p)
{
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block)
            add_block(z.data() + block * 512, beta, p.data() + block * 512);
    });
}

template<typename T>
void clear_inactive(const Blocks& blocks, std::vector<T>& v)
{
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t slot = first * 512; slot < last * 512; ++slot)
            if (!blocks.active(slot)) v[slot] = 0;
    });
}

/// Removes the mean over the active voxels, and whatever the others hold.
template<typename T>
void remove_mean(const Blocks& blocks, std::vector<T>& v)
{
    clear_inactive(blocks, v);
    const double mean = sum(blocks, v.data()) / double(std::max<size_t>(1, blocks.active_count()));
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) v[slot] -= T(mean);
}

void scale(double factor, std::vector<double>& v)
{
    for_ranges(v.size(), [&](size_t first, size_t last) {
        for (size_t slot = first; slot < last; ++slot) v[slot] *= factor;
    });
}

SolveResult solve(const Stencil& a, Multigrid& multigrid, double whole, double norm_asked, bool singular,
                  std::vector<double>& b, std::vector<double>& x, const SolveOptions& options)
{
    const Blocks& blocks = *a.blocks;
    std::vector<double>& r = b;
    const double norm = norm_asked > 0 ? std::clamp(norm_asked, least_norm * whole, whole) : whole;
    std::vector<float> p(blocks.slots(), 0.0f);
    std::vector<double> ap(blocks.slots(), 0.0);
    double energy = 0, rr = whole * whole, alpha = 0, rz_before = 0;
    if (x.empty())
        x.assign(blocks.slots(), 0.0);
    else {
        clear_inactive(blocks, x);
        energy = apply(a, x, ap);
        rr = advance(blocks, 1.0, p, ap, x, r);  // r = b - A x; p is 0
    }

    SolveResult result;
    while (true) {
        result.residual = norm > 0 ? std::sqrt(rr) / norm : 0.0;
        result.history.push_back(result.residual);
        report(options.progress, std::clamp(std::log(result.residual) / std::log(options.tolerance), 0.0, 1.0));
        if (result.residual == 0) {
            result.error = 0;
            result.converged = true;
        }
        if (result.converged || !std::isfinite(result.residual)) break;

        const auto [rz, apz] = multigrid.cycle(r, ap);
        result.error = energy > 0 ? std::sqrt(std::abs(rz) / energy) : 1.0;
        result.converged = result.residual <= options.tolerance && result.error <= options.tolerance;
        if (result.converged || result.iterations >= options.max_iterations || !(rz > 0)) break;

        // beta by Polak and Ribiere, z . (r - r_before) / rz_before, which allows for a cycle that is a slightly
        // different operator in each iteration.
        const double beta = rz_before > 0 ? -alpha * apz / rz_before : 0.0;
        add_direction(blocks, multigrid.z(), float(beta), p);
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

}  // namespace

SolveResult conjugate_gradient(const Stencil& a, Multigrid& multigrid, std::vector<double>& b, std::vector<double>& x,
                               const SolveOptions& options)
{
    const bool singular = std::all_of(a.extra.begin(), a.extra.end(), [](float e) { return e == 0; });
    if (singular) remove_mean(*a.blocks, b);
    double whole = std::sqrt(dot(*a.blocks, b.data(), b.data()));
    if (!(whole > 1e-100 && whole < 1e100)) {  // squares may be beyond double
        double largest = 0;
        for (const double value : b) largest = std::max(largest, std::abs(value));
        whole = std::isfinite(largest) ? largest : whole;
    }
    // The cycle works in single precision. Sources far from 1 are scaled by a power of two, which changes no digit.
    constexpr int far = 60;
    const int exponent = whole > 0 && std::isfinite(whole) ? std::ilogb(whole) : 0;
    if (std::abs(exponent) <= far) return solve(a, multigrid, whole, options.norm, singular, b, x, options);
    const double down = std::ldexp(1.0, -exponent), up = std::ldexp(1.0, exponent);
    scale(down, b);
    scale(down, x);
    whole = std::sqrt(dot(*a.blocks, b.data(), b.data()));
    const SolveResult result = solve(a, multigrid, whole, down * options.norm, singular, b, x, options);
    scale(up, b);
    scale(up, x);
    return result;
}

}  // namespace vdbcloud
