#pragma once
// Symmetric operators on graphs: the coarse levels of the multigrid. Private to solve/.
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace vdbcloud {

/// The operator (A x)_i = extra_i x_i + sum_j c_ij (x_i - x_j), c_ij = c_ji > 0, extra_i >= 0, row by row.
struct Graph {
    std::vector<uint32_t> begin{0};  ///< of each row in column and c; one more than there are unknowns
    std::vector<int32_t> column;
    std::vector<float> c;
    std::vector<float> extra;

    size_t size() const { return extra.size(); }
    size_t links() const { return column.size(); }
    size_t bytes() const { return 4 * (begin.size() + column.size() + c.size() + extra.size()); }
    /// Sum of the row's links.
    double linked(size_t i) const;

    /// Appends a link to the last row, which end_row() ends. A row has one link to a column.
    void add_link(int32_t to, double value)
    {
        column.push_back(to);
        c.push_back(float(value));
    }
    void end_row(double extra_of_row)
    {
        begin.push_back(uint32_t(column.size()));
        extra.push_back(float(extra_of_row));
    }
};

/// The operator whose rows are those of `parts` in turn; takes the parts.
Graph joined(std::vector<Graph>& parts);

/// Members of each group in rising order: member[first[g]] .. member[first[g + 1] - 1].
void list_members(const std::vector<int32_t>& group, size_t count, std::vector<uint32_t>& first,
                  std::vector<int32_t>& member);

/// The Galerkin operator P^T A P of interpolation P that is constant on groups. group[i] is that of unknown i, or -1 if
/// it has none: P is 0 there, and links to it hold the group as extra does. Links are sums in double, so the operator
/// is symmetric to the rounding of float.
Graph collapsed(const Graph& fine, const std::vector<int32_t>& group, size_t count);

}  // namespace vdbcloud
