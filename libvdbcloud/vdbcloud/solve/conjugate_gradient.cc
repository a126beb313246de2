#include "vdbcloud/solve/conjugate_gradient.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr double least_norm = 1e-9;  // of SolveOptions::norm over that of b

/// A field as the sum of two of single precision: 48 bits, in fields that a cycle leaves free.
struct Split {
    float *high, *low;
};

template<typename T>
VDBCLOUD_INLINE double apply_split(const StencilArrays& a, size_t block, const T* x, const Split& y)
{
    Doubles lanes{};
    over_rows<double>(
        a, block, Values<T>{x}, [&](size_t slot, Doubles v, Doubles product, Floats) __attribute__((always_inline)) {
            const Floats high = as<float>(product);
            store(y.high + slot, high);
            store(y.low + slot, as<float>(product - as<double>(high)));
            lanes += v * product;
        });
    return sum(lanes);
}

VDBCLOUD_CLONES double apply_block(const StencilArrays& a, size_t block, const float* x, const Split& y)
{
    return apply_split(a, block, x, y);
}

VDBCLOUD_CLONES double apply_block_double(const StencilArrays& a, size_t block, const double* x, const Split& y)
{
    return apply_split(a, block, x, y);
}

/// y = A p; returns p . y.
double apply(const Stencil& a, const std::vector<float>& p, const Split& y)
{
    const auto arrays = arrays_of(a);
    return ordered_sum(a.blocks->count(), [&](size_t block) { return apply_block(arrays, block, p.data(), y); });
}

double apply(const Stencil& a, const std::vector<double>& x, const Split& y)
{
    const auto arrays = arrays_of(a);
    return ordered_sum(a.blocks->count(), [&](size_t block) { return apply_block_double(arrays, block, x.data(), y); });
}

VDBCLOUD_CLONES double advance_block(double alpha, const float* p, const float* high, const float* low, double* x,
                                     double* r)
{
    const Doubles step = all(alpha);
    Doubles rr{};
    for (int row = 0; row < 512; row += 8) {
        store(x + row, load(x + row) + step * as<double>(load(p + row)));
        const Doubles ap = as<double>(load(high + row)) + as<double>(load(low + row));
        const Doubles left = load(r + row) - step * ap;
        store(r + row, left);
        rr += left * left;
    }
    return sum(rr);
}

/// x += alpha p, r -= alpha Ap; returns r . r.
double advance(const Blocks& blocks, double alpha, const std::vector<float>& p, const Split& ap, std::vector<double>& x,
               std::vector<double>& r)
{
    return ordered_sum(blocks.count(), [&](size_t block) {
        const size_t at = block * 512;
        return advance_block(alpha, p.data() + at, ap.high + at, ap.low + at, x.data() + at, r.data() + at);
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
    const Split ap{multigrid.scratch(0).data(), multigrid.scratch(1).data()};
    double energy = 0, rr = whole * whole, rz_before = 0;
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

        const double rz = multigrid.cycle(r);
        result.error = energy > 0 ? std::sqrt(std::abs(rz) / energy) : 1.0;
        result.converged = result.residual <= options.tolerance && result.error <= options.tolerance;
        if (result.converged || result.iterations >= options.max_iterations || !(rz > 0)) break;

        // beta by Fletcher and Reeves: that of Polak and Ribiere, for cycles that differ from one iteration to the
        // next, needs the last A p or residual, and saves no iteration where coarse corrections reduce their residual
        // by `enough`.
        const double beta = rz_before > 0 ? rz / rz_before : 0.0;
        add_direction(blocks, multigrid.z(), float(beta), p);
        if (singular) remove_mean(blocks, p);
        const double alpha = rz / apply(a, p, ap);
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
