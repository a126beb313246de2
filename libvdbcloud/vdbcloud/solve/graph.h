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

    /// Appends a row: links of one column are added up in rising order, so that the operator stays symmetric to the
    /// bit. `links` is cleared.
    void add_row(std::vector<std::pair<int32_t, float>>& links, double extra_of_row);
    /// Appends the rows of another part of the same operator.
    void append(const Graph& rows);
};

/// Members of each group in rising order: member[first[g]] .. member[first[g + 1] - 1].
void list_members(const std::vector<int32_t>& group, size_t count, std::vector<uint32_t>& first,
                  std::vector<int32_t>& member);

/// The Galerkin operator P^T A P of interpolation P that is constant on groups. group[i] is that of unknown i, or -1 if
/// it has none: P is 0 there, and links to it hold the group as extra does.
Graph collapsed(const Graph& fine, const std::vector<int32_t>& group, size_t count);

}  // namespace vdbcloud
