#include "vdbcloud/exchange/cell_field.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/voxel_transform.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double most_cells = 1 << 28;

/// Share of each cell of `from` in each cell of `to` that the cell overlaps.
struct Overlap {
    size_t from, to;
    double share;  // of the cell of `to`
};

std::vector<Overlap> overlaps(const std::vector<double>& from, const std::vector<double>& to)
{
    std::vector<Overlap> all;
    size_t first = 0;
    for (size_t t = 0; t + 1 < to.size(); ++t) {
        while (first + 2 < from.size() && from[first + 1] <= to[t]) ++first;
        for (size_t f = first; f + 1 < from.size() && from[f] < to[t + 1]; ++f) {
            const double low = std::max(from[f], to[t]), high = std::min(from[f + 1], to[t + 1]);
            if (high > low) all.push_back({f, t, (high - low) / (to[t + 1] - to[t])});
        }
    }
    return all;
}

/// Means along one axis of an array of counts[0] x counts[1] x counts[2], counts[0] fastest.
std::vector<float> along(const std::vector<float>& values, const std::array<size_t, 3>& counts, size_t axis,
                         const std::vector<Overlap>& overlaps, size_t new_count)
{
    std::array<size_t, 3> now = counts;
    now[axis] = new_count;
    const size_t stride = axis == 0 ? 1 : axis == 1 ? counts[0] : counts[0] * counts[1];
    const size_t outer = values.size() / (stride * counts[axis]);
    std::vector<float> means(stride * new_count * outer);
    std::vector<double> line(new_count);
    for (size_t o = 0; o < outer; ++o)
        for (size_t s = 0; s < stride; ++s) {
            std::fill(line.begin(), line.end(), 0.0);
            for (const Overlap& part : overlaps)
                line[part.to] += part.share * double(values[s + stride * (part.from + counts[axis] * o)]);
            for (size_t k = 0; k < new_count; ++k) means[s + stride * (k + new_count * o)] = float(line[k]);
        }
    return means;
}

double smallest(const std::vector<double>& edges)
{
    double least = edges[1] - edges[0];
    for (size_t k = 1; k + 1 < edges.size(); ++k) least = std::min(least, edges[k + 1] - edges[k]);
    return least;
}

}  // namespace

std::vector<double> edges_between(const std::vector<double>& centres, double single, const std::string& what)
{
    if (centres.size() == 1) return {centres[0] - single / 2, centres[0] + single / 2};
    std::vector<double> edges(centres.size() + 1);
    for (size_t k = 1; k < centres.size(); ++k) {
        if (!(centres[k] > centres[k - 1]) || !std::isfinite(centres[k]))
            throw InputError(what + ": " + shortest(centres[k - 1]) + " is followed by " + shortest(centres[k]) +
                             ": expected coordinates that rise or fall throughout");
        edges[k] = 0.5 * (centres[k - 1] + centres[k]);
    }
    edges.front() = 2 * centres.front() - edges[1];
    edges.back() = 2 * centres.back() - edges[centres.size() - 1];
    return edges;
}

std::vector<double> equal_edges(double first, double size, size_t count)
{
    std::vector<double> edges(count + 1);
    for (size_t k = 0; k <= count; ++k) edges[k] = first + double(k) * size;
    return edges;
}

bool are_equal(const std::vector<double>& edges)
{
    const double mean = (edges.back() - edges.front()) / double(edges.size() - 1);
    for (size_t k = 0; k + 1 < edges.size(); ++k)
        if (std::abs(edges[k + 1] - edges[k] - mean) > 1e-3 * mean) return false;
    return true;
}

Cells equal_cells(const Cells& cells, const Vec3d& size)
{
    double counts[3], sizes[3];
    for (size_t a = 0; a < 3; ++a) {
        const double length = cells.length(a);
        const bool keep = !(size[int(a)] > 0) && are_equal(cells.edges[a]);
        sizes[a] = size[int(a)] > 0 ? size[int(a)] : keep ? length / double(cells.count(a)) : smallest(cells.edges[a]);
        counts[a] = keep ? double(cells.count(a)) : std::max(1.0, std::ceil(length / sizes[a] - 1e-6));
    }
    if (!(counts[0] * counts[1] * counts[2] <= most_cells))
        throw InputError(shortest(counts[0]) + " x " + shortest(counts[1]) + " x " + shortest(counts[2]) +
                         " equal cells: expected at most 2^28; use larger cells (--cell)");
    Cells equal;
    for (size_t a = 0; a < 3; ++a) equal.edges[a] = equal_edges(cells.edges[a].front(), sizes[a], size_t(counts[a]));
    return equal;
}

std::vector<float> resampled(const Cells& from, const std::vector<float>& values, const Cells& to)
{
    std::vector<float> now = values;
    std::array<size_t, 3> counts{from.count(0), from.count(1), from.count(2)};
    for (size_t a = 0; a < 3; ++a) {
        const std::vector<double>&old = from.edges[a], &wanted = to.edges[a];
        const bool same = counts[a] == to.count(a) && are_equal(old) &&
                          std::abs(old.front() - wanted.front()) <= 1e-6 * from.length(a) &&
                          std::abs(old.back() - wanted.back()) <= 1e-6 * from.length(a);
        if (same) continue;
        now = along(now, counts, a, overlaps(old, wanted), to.count(a));
        counts[a] = to.count(a);
    }
    return now;
}

std::shared_ptr<Transform> cell_transform(const Cells& equal, UpAxis up, double unit)
{
    Vec3d size(0.0), first(0.0);
    for (size_t a = 0; a < 3; ++a) {
        size[int(a)] = (equal.edges[a][1] - equal.edges[a][0]) / unit;
        first[int(a)] = equal.edges[a][0] / unit + 0.5 * size[int(a)];
    }
    if (up == UpAxis::Y) {
        // Index z counts down along the cells' y, so that both turn the same way.
        const double last = equal.edges[1].back() / unit - 0.5 * size[1];
        size = Vec3d(size[0], size[2], size[1]);
        first = Vec3d(first[0], first[2], -last);
    }
    auto transform = voxel_transform(size);
    transform->postTranslate(first);
    return transform;
}

std::array<int, 3> cell_index(const Cells& equal, UpAxis up, size_t i, size_t j, size_t k)
{
    if (up == UpAxis::Z) return {int(i), int(j), int(k)};
    return {int(i), int(k), int(equal.count(1) - 1 - j)};
}

FloatGridPtr cell_grid(const Cells& equal, const std::vector<float>& values, UpAxis up, double unit, double factor)
{
    auto grid = FloatGrid::create(0.0f);
    grid->setTransform(cell_transform(equal, up, unit));
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto set = grid->getAccessor();
    size_t at = 0;
    for (size_t k = 0; k < equal.count(2); ++k)
        for (size_t j = 0; j < equal.count(1); ++j)
            for (size_t i = 0; i < equal.count(0); ++i, ++at) {
                const auto value = float(factor * double(values[at]));
                const auto index = cell_index(equal, up, i, j, k);
                if (value > 0) set.setValueOn(openvdb::Coord(index[0], index[1], index[2]), value);
            }
    return grid;
}

}  // namespace vdbcloud
