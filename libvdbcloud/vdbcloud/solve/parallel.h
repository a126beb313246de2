#pragma once
// Loops over blocks: threads by TBB, sums in a fixed order.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
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

/// Calls f(k) for k = 0..count, each a task of its own.
template<typename F>
void for_each(size_t count, const F& f)
{
    tbb::parallel_for(size_t(0), count, f);
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

constexpr size_t rows_at_once = 512;

/// Calls f(i) for each row of a graph.
template<typename F>
void for_rows(size_t count, const F& f)
{
    for_ranges((count + rows_at_once - 1) / rows_at_once, [&](size_t first, size_t last) {
        for (size_t i = first * rows_at_once; i < std::min(count, last * rows_at_once); ++i) f(i);
    });
}

constexpr size_t batches_at_once = rows_at_once / 8;

/// Calls f(first, last) for ranges that cover the batches of eight rows of a graph.
template<typename F>
void for_batches(size_t count, const F& f)
{
    for_ranges((count + batches_at_once - 1) / batches_at_once,
               [&](size_t first, size_t last) { f(first * batches_at_once, std::min(count, last * batches_at_once)); });
}

/// f(first, last, sums) finds n sums over a range of batches of eight rows; the sums of the ranges, which do not depend
/// on the number of threads, are added in order.
template<size_t n, typename F>
std::array<double, n> ordered_batch_sums(size_t count, const F& f)
{
    std::vector<std::array<double, n>> terms((count + batches_at_once - 1) / batches_at_once);
    for_ranges(terms.size(), [&](size_t first, size_t last) {
        for (size_t k = first; k < last; ++k)
            f(k * batches_at_once, std::min(count, (k + 1) * batches_at_once), terms[k].data());
    });
    std::array<double, n> total{};
    for (const auto& term : terms)
        for (size_t s = 0; s < n; ++s) total[s] += term[s];
    return total;
}

}  // namespace vdbcloud
