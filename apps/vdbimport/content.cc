#include "content.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double edges[] = {8, 128, 4096};

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
    for (const MediumBox& box : boxes) {
        double voxels = 1, touched[] = {1, 1, 1}, filled = 1;
        for (int a = 0; a < 3; ++a) {
            const double low = std::ceil(box.low[a] / cell[a] - 0.5), high = std::ceil(box.high[a] / cell[a] - 0.5);
            voxels *= std::max(high - low, 0.0);
            for (int k = 0; k < 3; ++k)
                touched[k] *= std::max(std::ceil(high / edges[k]) - std::floor(low / edges[k]), 0.0);
            filled *= std::max(std::floor(high / edges[0]) - std::ceil(low / edges[0]), 0.0);
        }
        content.voxels += voxels;
        content.blocks[0] += touched[0] - filled;
        for (const int k : {1, 2}) content.blocks[k] += touched[k];
    }
    return content;
}

}  // namespace vdbcloud
