#pragma once
// Values on rectilinear cells, as models of the atmosphere write them, and their way onto the equal cells of a grid.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/grid/up_axis.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

/// Cells between rising edges along x, y and z, z upwards.
struct Cells {
    std::array<std::vector<double>, 3> edges;  ///< of each axis, one more than it has cells

    size_t count(size_t axis) const { return edges[axis].size() - 1; }
    size_t size() const { return count(0) * count(1) * count(2); }
    double length(size_t axis) const { return edges[axis].back() - edges[axis].front(); }
};

/// Edges between `centres`, in the middle between neighbours; the outermost cells are symmetric about their centres.
/// A single centre gets a cell of size `single`. Throws InputError, with `what`, unless the centres rise.
std::vector<double> edges_between(const std::vector<double>& centres, double single, const std::string& what);

/// Edges of `count` cells of one size from `first` on.
std::vector<double> equal_edges(double first, double size, size_t count);

/// True if the sizes of the cells differ by less than 1e-3 of their mean, which floats of a file round to.
bool are_equal(const std::vector<double>& edges);

/// Equal cells of the extent of `cells`. Axes whose cells are equal keep them; others get cells of the smallest size
/// that occurs. A size above 0 in `size` replaces that of an axis. The last cell may reach beyond the extent. Throws
/// InputError for more than 2^28 cells.
Cells equal_cells(const Cells& cells, const Vec3d& size);

/// Mean of `values` (x fastest) over each cell of `to`; outside `from` values count as 0. The integral over each line
/// of cells is kept.
std::vector<float> resampled(const Cells& from, const std::vector<float>& values, const Cells& to);

/// The transform of equal cells. `unit`: metres, or what the edges are in, of a world unit. With UpAxis::Z world x, y,
/// z are those of the cells; with UpAxis::Y they are x, z, -y, which is a rotation.
std::shared_ptr<Transform> cell_transform(const Cells& equal, UpAxis, double unit);

/// A fog volume of the values above 0, times `factor`.
FloatGridPtr cell_grid(const Cells& equal, const std::vector<float>& values, UpAxis, double unit, double factor);

/// Index of cell i, j, k in a grid of cell_transform().
std::array<int, 3> cell_index(const Cells& equal, UpAxis, size_t i, size_t j, size_t k);

}  // namespace vdbcloud
