#include "vdbcloud/sweep/void_beams.h"

#include "vdbcloud/sweep/block_walk.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdbcloud {

using block_sweep::region_axes;
using block_sweep::Traversal;

VoidBeam::Entry face_entry(const Traversal& traversal, int face, const double* at, double share)
{
    const int across = traversal.axis[size_t(face)];
    const int runs[2] = {face == 0 ? 1 : 0, face == 2 ? 1 : 2};
    VoidBeam::Entry entry{0, uint8_t(face), 0, {}};
    double f[2];
    for (int k = 0; k < 2; ++k) {
        const int other = traversal.axis[size_t(runs[k])];
        const double on =
            std::clamp(at[other] - 0.5 * traversal.step[other] / std::abs(traversal.step[across]), 0.0, 7.0);
        const int cell = std::min(int(on), 6);
        f[k] = on - cell;
        entry.cell = uint8_t(entry.cell + (k == 0 ? 8 : 1) * cell);
    }
    for (int n = 0; n < 4; ++n) entry.weight[n] = float(share * (n & 2 ? f[0] : 1 - f[0]) * (n & 1 ? f[1] : 1 - f[1]));
    return entry;
}

Vec3d region_corner(const Traversal& traversal, int region, const Vec3i& block)
{
    Vec3d corner;
    for (int k = 0; k < 3; ++k) {
        const int a = traversal.axis[size_t(k)];
        corner[a] = 8 * block[a] + (region_axes[region] >> k & 1 ? traversal.before[size_t(k)] : 0);
    }
    return corner;
}

std::array<int, 2> region_runs(const Traversal& traversal, int region)
{
    std::array<int, 2> runs{-1, -1};
    int n = 0;
    for (int k = 0; k < 3; ++k)
        if (!(region_axes[region] >> k & 1)) runs[size_t(n++)] = traversal.axis[size_t(k)];
    return runs;
}

VoidBeam::VoidBeam(const Traversal& traversal, int region, int walls)
{
    const std::array<int, 2> runs = region_runs(traversal, region);
    const Vec3d corner = region_corner(traversal, region, Vec3i(0));
    const auto length = [](const Vec3i& v) { return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z()); };
    struct Enters {
        Vec3i offset;
        Entry entry;
    };
    std::vector<Enters> all;
    for (int ray = 0; ray < block_sweep::region_size(region); ++ray) {
        Vec3d from = corner;
        const int row = ray / 8;
        if (runs[1] >= 0) from[runs[0]] += row;
        if (runs[0] >= 0) from[runs[1] >= 0 ? runs[1] : runs[0]] += ray % 8;
        Walk walk(from, traversal.step);
        const int start = length(walk.block);
        while (length(walk.block) < start + walls) {
            const int axes = walk.cross(0);
            double at[3];
            for (int a = 0; a < 3; ++a) at[a] = walk.in_block(axes, a);
            for (int face = 0; face < 3; ++face) {
                if (!(axes >> traversal.axis[size_t(face)] & 1)) continue;
                all.push_back({walk.block, face_entry(traversal, face, at, 1.0 / __builtin_popcount(unsigned(axes)))});
                all.back().entry.ray = uint8_t(ray);
            }
        }
    }
    std::stable_sort(all.begin(), all.end(), [&](const Enters& a, const Enters& b) {
        const int la = length(a.offset), lb = length(b.offset);
        return la != lb ? la < lb : a.offset < b.offset;
    });
    for (const Enters& each : all) {
        if (crossings.empty() || crossings.back().offset != each.offset)
            crossings.push_back({each.offset, 0, uint32_t(entries.size()), 0});
        crossings.back().rays |= uint64_t(1) << each.entry.ray;
        ++crossings.back().entries;
        entries.push_back(each.entry);
    }
}

}  // namespace vdbcloud
