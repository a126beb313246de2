#include "content.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

namespace vdbcloud {

namespace {

constexpr double edges[] = {8, 128, 4096};
constexpr double most_named = 64;  // blocks of a box that are told from those of other boxes

/// The blocks that the voxels low to high - 1 touch, or those that they fill.
struct Span {
    double first[3], last[3];  // first to last - 1

    Span(const double* low, const double* high, double edge, bool whole)
    {
        for (int a = 0; a < 3; ++a) {
            first[a] = whole ? std::ceil(low[a] / edge) : std::floor(low[a] / edge);
            last[a] = whole ? std::floor(high[a] / edge) : std::ceil(high[a] / edge);
        }
    }
    double count() const
    {
        double product = 1;
        for (int a = 0; a < 3; ++a) product *= std::max(last[a] - first[a], 0.0);
        return product;
    }
    bool has(const std::array<int64_t, 3>& block) const
    {
        bool in = true;
        for (size_t a = 0; a < 3; ++a) in = in && double(block[a]) >= first[a] && double(block[a]) < last[a];
        return in;
    }
    /// For few blocks, whose numbers are those of voxels of a grid.
    void each(const std::function<void(const std::array<int64_t, 3>&)>& f) const
    {
        for (auto i = int64_t(first[0]); i < int64_t(last[0]); ++i)
            for (auto j = int64_t(first[1]); j < int64_t(last[1]); ++j)
                for (auto k = int64_t(first[2]); k < int64_t(last[2]); ++k) f({i, j, k});
    }
};

}  // namespace

Content content_of_columns(size_t nx, size_t ny, const std::function<double(size_t, size_t)>& layers)
{
    Content content;
    for (size_t y = 0; y < ny; ++y)
        for (size_t x = 0; x < nx; ++x) content.voxels += layers(x, y);
    for (int k = 0; k < 3; ++k) {
        const auto edge = size_t(edges[k]);
        for (size_t y0 = 0; y0 < ny; y0 += edge)
            for (size_t x0 = 0; x0 < nx; x0 += edge) {
                double highest = 0;
                for (size_t y = y0; y < std::min(y0 + edge, ny); ++y)
                    for (size_t x = x0; x < std::min(x0 + edge, nx); ++x) highest = std::max(highest, layers(x, y));
                content.blocks[k] += std::ceil(highest / edges[k]);
            }
    }
    return content;
}

Content content_of_boxes(const std::vector<MediumBox>& boxes, const Vec3d& cell)
{
    Content content;
    std::set<std::array<int64_t, 3>> seen[3];
    for (const MediumBox& box : boxes) {
        double voxels = 1, low[3], high[3];
        for (int a = 0; a < 3; ++a) {
            low[a] = std::ceil(box.low[a] / cell[a] - 0.5);
            high[a] = std::ceil(box.high[a] / cell[a] - 0.5);
            voxels *= std::max(high[a] - low[a], 0.0);
        }
        content.voxels += voxels;
        for (int k = 0; k < 3 && voxels > 0; ++k) {
            const Span touched(low, high, edges[k], false), filled(low, high, edges[k], true);
            const bool tiles = k == 0;  // of blocks that are filled
            if (touched.count() > most_named)
                content.blocks[k] += touched.count() - (tiles ? filled.count() : 0);
            else
                touched.each([&](const std::array<int64_t, 3>& block) {
                    if (!tiles || !filled.has(block)) content.blocks[k] += seen[k].insert(block).second;
                });
        }
    }
    return content;
}

}  // namespace vdbcloud
