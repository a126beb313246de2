#include "vdbcloud/solve/relaxation.h"

#include "vdbcloud/solve/parallel.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// One half sweep over the voxels of one colour, which only have neighbours of the other.
void half_sweep(const Stencil& a, int colour, double factor, const std::vector<double>& b, std::vector<double>& x)
{
    const Blocks& blocks = *a.blocks;
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t slot = first * 512; slot < last * 512; ++slot) {
            const size_t in = slot % 512;
            if (int((in / 64 + in / 8 + in) & 1) != colour || !blocks.active(slot)) continue;
            double diagonal = a.extra[slot], pull = b[slot];
            for (int face = 0; face < 6; ++face) {
                const size_t to = blocks.neighbour(slot, face);
                const double c = a.face[face / 2][face % 2 ? slot : to];
                diagonal += c;
                pull += c * x[to];
            }
            if (diagonal > 0) x[slot] += factor * (pull / diagonal - x[slot]);
        }
    });
}

}  // namespace

SolveResult relax(const Stencil& a, double factor, std::vector<double>& b, std::vector<double>& x,
                  const SolveOptions& options)
{
    const Blocks& blocks = *a.blocks;
    if (x.empty()) x.assign(blocks.slots(), 0.0);
    std::vector<double> r(blocks.slots(), 0.0);
    const double norm = std::sqrt(dot(blocks, b.data(), b.data()));
    SolveResult result;
    while (true) {
        apply(a, x, r);
        for (size_t slot = 0; slot < r.size(); ++slot) r[slot] = b[slot] - r[slot];
        result.residual = norm > 0 ? std::sqrt(dot(blocks, r.data(), r.data())) / norm : 0.0;
        result.history.push_back(result.residual);
        report(options.progress, std::min(1.0, std::log(result.residual) / std::log(options.tolerance)));
        result.converged = result.residual <= options.tolerance;
        if (result.converged || !std::isfinite(result.residual) || result.iterations >= options.max_iterations) break;
        for (int sweep = 0; sweep < 10 && result.iterations < options.max_iterations; ++sweep, ++result.iterations)
            for (int colour : {0, 1}) half_sweep(a, colour, factor, b, x);
    }
    b.swap(r);
    return result;
}

}  // namespace vdbcloud
