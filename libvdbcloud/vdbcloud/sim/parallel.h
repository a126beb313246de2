#pragma once
// Loops over planes on all threads, whose results do not depend on the number of threads. Private to sim/.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <vector>

namespace vdbcloud::sim {

/// Calls f(begin, end) for consecutive chunks of [0, n) of length `grain` (the last may be shorter), in parallel. The
/// chunks do not depend on the number of threads.
template<typename F>
void for_chunks(int n, int grain, const F& f)
{
    const int chunks = (n + grain - 1) / grain;
    if (chunks <= 1) {
        if (n > 0) f(0, n);
        return;
    }
    tbb::parallel_for(
        tbb::blocked_range<int>(0, chunks),
        [&](const tbb::blocked_range<int>& r) {
            for (int c = r.begin(); c < r.end(); ++c) f(c * grain, std::min(n, (c + 1) * grain));
        },
        tbb::simple_partitioner());
}

/// Planes a task: few enough that all threads have work, many enough that starting a task costs little.
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
