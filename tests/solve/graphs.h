#pragma once
// Random graphs and their operator in double precision, for the solver's tests.
#include "vdbcloud/core/random.h"
#include "vdbcloud/solve/graph.h"

#include <functional>
#include <map>

namespace vdbcloud::test {

using Vector = std::vector<double>;
using Operator = std::function<Vector(const Vector&)>;

inline Vector product(const Graph& a, const Vector& x)
{
    Vector y(a.size());
    for (size_t i = 0; i < a.size(); ++i) {
        y[i] = a.extra[i] * x[i];
        for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) y[i] += a.c[k] * (x[i] - x[size_t(a.column[k])]);
    }
    return y;
}

/// Appends a row; links to one column are added up.
inline void add_row(Graph& graph, const std::vector<std::pair<int32_t, float>>& links, double extra)
{
    std::map<int32_t, double> sums;
    for (const auto& [to, c] : links) sums[to] += c;
    for (const auto& [to, c] : sums) graph.add_link(to, c);
    graph.end_row(extra);
}

/// A symmetric graph of n unknowns with about four links each, in `parts` that are not linked.
inline Graph random_graph(size_t n, size_t parts, double extra)
{
    std::vector<std::vector<std::pair<int32_t, float>>> links(n);
    const auto join = [&](size_t i, size_t j, uint64_t seed) {
        const float c = float(0.1 + uniform(hash_bits(seed, i, j)));
        links[i].emplace_back(int32_t(j), c);
        links[j].emplace_back(int32_t(i), c);
    };
    for (size_t i = 0; i < n; ++i) {
        if (i + parts < n) join(i, i + parts, 1);
        const size_t j = hash_bits(7, i) % n;
        if (j % parts == i % parts && j != i) join(i, j, 2);
    }
    Graph graph;
    for (size_t i = 0; i < n; ++i) add_row(graph, links[i], extra * uniform(hash_bits(3, i)));
    return graph;
}

inline Vector random_vector(size_t n, uint64_t seed)
{
    Vector x(n);
    for (size_t i = 0; i < n; ++i) x[i] = uniform(hash_bits(seed, i)) - 0.5;
    return x;
}

}  // namespace vdbcloud::test
