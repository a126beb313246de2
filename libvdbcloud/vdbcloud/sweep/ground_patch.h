#pragma once
// A patch of the endless ground beneath a medium that ends on all sides.
#include "vdbcloud/voxels/active_box.h"

#include <cmath>

namespace vdbcloud {

/// Square cells of `edge` voxels in a plane of voxel centres. The middles of cells are voxel centres. Cells are
/// numbered row by row: ActiveBox::axes()[1] runs fastest.
struct GroundPatch {
    int face = 0;                    ///< Blocks::Face: the side of the medium that looks down on the ground
    int plane = 0;                   ///< voxel coordinate across it
    std::array<int, 2> first{0, 0};  ///< voxel coordinates of the first middle
    std::array<int, 2> count{0, 0};  ///< cells along both axes
    int edge = 1;                    ///< [voxels]

    size_t cells() const { return size_t(count[0]) * size_t(count[1]); }
    Vec3i middle(int row, int column) const
    {
        const auto [u, v] = ActiveBox::axes(face / 2);
        Vec3i at;
        at[face / 2] = plane;
        at[u] = first[0] + row * edge;
        at[v] = first[1] + column * edge;
        return at;
    }
    Vec3i middle(size_t cell) const { return middle(int(cell) / count[1], int(cell) % count[1]); }

    /// Bilinear between middles, at the voxel coordinates p of both axes. Cells beyond the patch count as 0.
    double interpolate(const std::vector<float>& values, const std::array<double, 2>& p) const
    {
        double f[2];
        int low[2];
        for (size_t k = 0; k < 2; ++k) {
            const double at = (p[k] - first[k]) / edge;
            if (!(at > -1 && at < count[k])) return 0;
            low[k] = int(std::floor(at));
            f[k] = at - low[k];
        }
        double sum = 0;
        for (int n = 0; n < 4; ++n) {
            const int row = low[0] + (n >> 1), column = low[1] + (n & 1);
            if (row < 0 || row >= count[0] || column < 0 || column >= count[1]) continue;
            sum += (n >> 1 ? f[0] : 1 - f[0]) * (n & 1 ? f[1] : 1 - f[1]) *
                   values[size_t(row) * size_t(count[1]) + size_t(column)];
        }
        return sum;
    }
};

}  // namespace vdbcloud
