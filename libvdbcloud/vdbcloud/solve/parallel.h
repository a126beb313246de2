#pragma once
// Loops over blocks: threads by TBB, sums in a fixed order.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <vector>

namespace vdbcloud {

/// Calls f(first, last) for ranges that cover 0..count; serially if there is little to do.
template<typename F>
void for_ranges(size_t count, const F& f)
{
    constexpr size_t serial = 24, grain = 8;
    if (count <= serial) {
        if (count) f(size_t(0), count);
        return;
    }
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                      [&](const tbb::blocked_range<size_t>& r) { f(r.begin(), r.end()); });
}

/// Sum of f(k) over k = 0..count, each evaluated by any thread, added in order of k.
template<typename F>
double ordered_sum(size_t count, const F& f)
{
    std::vector<double> terms(count);
    for_ranges(count, [&](size_t first, size_t last) {
        for (size_t k = first; k < last; ++k) terms[k] = f(k);
    });
    double total = 0;
    for (double term : terms) total += term;
    return total;
}

}  // namespace vdbcloud
