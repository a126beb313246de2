#pragma once
// Loops over planes on all threads, with results that do not depend on how many there are.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <vector>

namespace vdbcloud::sim {

/// Calls f(begin, end) for consecutive blocks of [0, n) of `grain` (the last may be shorter): the blocks are fixed,
/// only who computes them varies.
template<typename F>
void for_chunks(int n, int grain, const F& f)
{
    const int blocks = (n + grain - 1) / grain;
    if (blocks <= 1) {
        if (n > 0) f(0, n);
        return;
    }
    tbb::parallel_for(
        tbb::blocked_range<int>(0, blocks),
        [&](const tbb::blocked_range<int>& r) {
            for (int b = r.begin(); b < r.end(); ++b) f(b * grain, std::min(n, (b + 1) * grain));
        },
        tbb::simple_partitioner());
}

/// A block of planes worth a task: small enough to share among threads, large enough to pay for its start.
inline int plane_grain(int planes) { return std::max(2, planes / 16); }

/// Combines f(k), one value a plane, in order of k.
template<typename V, typename F, typename Join>
V reduce_planes(int n, V start, const F& f, const Join& join)
{
    std::vector<V> part(static_cast<size_t>(n), start);
    for_chunks(n, plane_grain(n), [&](int begin, int end) {
        for (int k = begin; k < end; ++k) part[size_t(k)] = f(k);
    });
    for (const V& p : part) start = join(start, p);
    return start;
}

}  // namespace vdbcloud::sim
