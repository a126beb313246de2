#include "vdbcloud/voxels/active_box.h"

#include <algorithm>
#include <limits>

namespace vdbcloud {

ActiveBox::ActiveBox(const Blocks& blocks)
{
    if (!blocks.count()) return;
    first = Vec3i(std::numeric_limits<int>::max());
    last = Vec3i(std::numeric_limits<int>::min());
    for (size_t b = 0; b < blocks.count(); ++b) {
        uint64_t layers = 0, rows = 0, columns = 0;  // bit k: a voxel of coordinate k is active, by axis
        uint64_t all = 0;
        for (size_t x = 0; x < 8; ++x) {
            all |= blocks.mask(b)[x];
            layers |= uint64_t(blocks.mask(b)[x] != 0) << x;
        }
        for (int y = 0; y < 8; ++y) {
            const uint64_t row = all >> (8 * y) & 255;
            rows |= uint64_t(row != 0) << y;
            columns |= row;
        }
        const uint64_t used[3] = {layers, rows, columns};
        for (int a = 0; a < 3; ++a)
            for (int k = 0; k < 8; ++k) {
                if (!(used[a] >> k & 1)) continue;
                first[a] = std::min(first[a], 8 * blocks.at(b)[a] + k);
                last[a] = std::max(last[a], 8 * blocks.at(b)[a] + k);
            }
    }
    for (int a = 0; a < 3; ++a) {
        periodic[size_t(a)] = blocks.period()[a] != 0;
        if (!periodic[size_t(a)]) continue;
        first[a] = 0;  // a period may begin or end with empty voxels
        last[a] = 8 * blocks.period()[a] - 1;
    }
}

bool ActiveBox::contains(const Vec3i& at) const
{
    for (int a = 0; a < 3; ++a)
        if (at[a] < first[a] || at[a] > last[a]) return false;
    return true;
}

size_t ActiveBox::cells(int face) const
{
    const auto [u, v] = axes(face / 2);
    return empty() || periodic[size_t(face / 2)] ? 0 : size_t(size(u)) * size_t(size(v));
}

size_t ActiveBox::cell(int face, const Vec3i& at) const
{
    const auto [u, v] = axes(face / 2);
    return size_t(at[u] - first[u]) * size_t(size(v)) + size_t(at[v] - first[v]);
}

Vec3i ActiveBox::voxel(int face, size_t cell) const
{
    const auto [u, v] = axes(face / 2);
    Vec3i at;
    at[face / 2] = face % 2 ? last[face / 2] : first[face / 2];
    at[u] = first[u] + int(cell / size_t(size(v)));
    at[v] = first[v] + int(cell % size_t(size(v)));
    return at;
}

}  // namespace vdbcloud
