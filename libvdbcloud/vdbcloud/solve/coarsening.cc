#include "vdbcloud/solve/coarsening.h"

#include "vdbcloud/solve/parallel.h"

#include <map>
#include <tuple>


namespace vdbcloud {

namespace {

// The coarse operator must not be much softer than what interpolation makes of the fine one, or the cycle overshoots
// and is no longer positive definite: never below half of the faces between two groups, the value for constant coefficients.
constexpr float least_share = 0.5f;

/// Where a fine block's coordinate stands in the coarse level along one axis: one place, or two if the coarse level
/// covers two periods.
struct Places {
    int count = 0, coarse[2], half[2];
};

Places places(int at, int period)
{
    Places p;
    for (int t = at; p.count < (period % 2 ? 2 : 1); t += period) {
        p.coarse[p.count] = t >> 1;
        p.half[p.count++] = t & 1;
    }
    return p;
}

/// The 4^3 voxels of one octant of a coarse mask: set where any of 2^3 fine bits is.
void add_to_mask(const BlockMask& fine, int ox, int oy, int oz, BlockMask& coarse)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z)
                if (fine[x] >> (y * 8 + z) & 1)
                    coarse[ox * 4 + x / 2] |= uint64_t(1) << ((oy * 4 + y / 2) * 8 + oz * 4 + z / 2);
}

double series(double a, double b) { return a > 0 && b > 0 ? a * b / (a + b) : 0.0; }

/// Sums over the fine faces of each coarse voxel along one axis: inside it, and to the next one up.
struct FaceSums {
    std::vector<float> inner, outer;
};

FaceSums face_sums(const Stencil& fine, const CoarseMap& map, size_t coarse_slots, int axis)
{
    FaceSums sums{std::vector<float>(coarse_slots, 0.0f), std::vector<float>(coarse_slots, 0.0f)};
    static constexpr int stride[3] = {64, 8, 1};
    for_ranges(map.children.size(), [&](size_t first, size_t last) {
        for (size_t b = first; b < last; ++b)
            for (int o = 0; o < 8; ++o) {
                const float* c = fine.face[axis].data() + size_t(map.children[b][o]) * 512;
                const size_t corner = b * 512 + (o >> 2) * 256 + (o >> 1 & 1) * 32 + (o & 1) * 4;
                for (int i = 0; i < 512; ++i) {
                    const size_t to = corner + (i >> 7) * 64 + (i >> 4 & 3) * 8 + (i >> 1 & 3);
                    (i / stride[axis] % 2 ? sums.outer : sums.inner)[to] += c[i];
                }
            }
    });
    return sums;
}

}  // namespace

Blocks coarse_blocks(const Blocks& fine, CoarseMap& map)
{
    Vec3i period(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis)
        period[axis] = fine.period()[axis] % 2 ? fine.period()[axis] : fine.period()[axis] / 2;

    std::map<std::tuple<int, int, int>, Block> found;
    const auto each_place = [&](size_t b, auto&& visit) {
        Places p[3];
        for (int axis = 0; axis < 3; ++axis) p[axis] = places(fine.at(b)[axis], fine.period()[axis]);
        for (int i = 0; i < p[0].count; ++i)
            for (int j = 0; j < p[1].count; ++j)
                for (int k = 0; k < p[2].count; ++k)
                    visit(Vec3i(p[0].coarse[i], p[1].coarse[j], p[2].coarse[k]), p[0].half[i], p[1].half[j], p[2].half[k]);
    };
    for (size_t b = 0; b < fine.count(); ++b)
        each_place(b, [&](const Vec3i& at, int ox, int oy, int oz) {
            Block& block = found.try_emplace({at.x(), at.y(), at.z()}, Block{at, {}}).first->second;
            add_to_mask(fine.mask(b), ox, oy, oz, block.mask);
        });
    std::vector<Block> list;
    for (const auto& entry : found) list.push_back(entry.second);
    Blocks coarse(std::move(list), period);

    std::array<int32_t, 8> none;
    none.fill(int32_t(fine.count()));
    map.parent.assign(fine.count(), -1);
    map.octant.assign(fine.count(), 0);
    map.children.assign(coarse.count(), none);
    for (size_t b = 0; b < fine.count(); ++b)
        each_place(b, [&](const Vec3i& at, int ox, int oy, int oz) {
            const int32_t parent = coarse.find(at);
            map.children[parent][ox * 4 + oy * 2 + oz] = int32_t(b);
            if (map.parent[b] >= 0) return;  // the first place is the one in the first period
            map.parent[b] = parent;
            map.octant[b] = uint8_t(ox * 4 + oy * 2 + oz);
        });
    return coarse;
}

void coarse_stencil(const Stencil& fine, const std::vector<float>& fine_boundary, const CoarseMap& map, Stencil& coarse,
                    std::vector<float>& coarse_boundary)
{
    const Blocks& blocks = *coarse.blocks;
    coarse_boundary.assign(blocks.slots(), 0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        const auto sums = face_sums(fine, map, blocks.slots(), axis);
        for_ranges(blocks.count(), [&](size_t first, size_t last) {
            for (size_t slot = first * 512; slot < last * 512; ++slot) {
                double c = sums.outer[slot];
                if (!(c > 0)) continue;
                const float below = sums.inner[slot], above = sums.inner[blocks.neighbour(slot, 2 * axis + 1)];
                if (below > 0) c = series(c, 2.0 * below);
                if (above > 0) c = series(c, 2.0 * above);
                coarse.face[axis][slot] = std::max(float(c), least_share * sums.outer[slot]);
            }
        });
    }
    static constexpr int stride[3] = {64, 8, 1};
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t b = first; b < last; ++b)
            for (int o = 0; o < 8; ++o) {
                const size_t child = size_t(map.children[b][o]) * 512;
                const size_t corner = b * 512 + (o >> 2) * 256 + (o >> 1 & 1) * 32 + (o & 1) * 4;
                for (int i = 0; i < 512; ++i) {
                    const double outside = fine_boundary[child + i], all = fine.extra[child + i];
                    if (!(all > 0)) continue;
                    double inner = 0, seen = outside;  // half of the mean conductance to its partners in the group
                    int partners = 0;
                    for (int axis = 0; axis < 3; ++axis) {
                        const bool upper = i / stride[axis] % 2;
                        const float c = fine.face[axis][child + (upper ? i - stride[axis] : i)];
                        inner += c;
                        partners += c > 0;
                    }
                    if (partners && outside > 0) seen = series(outside, 2 * inner / partners);
                    const size_t to = corner + (i >> 7) * 64 + (i >> 4 & 3) * 8 + (i >> 1 & 3);
                    coarse_boundary[to] += float(seen);
                    coarse.extra[to] += float(seen + (all - outside));
                }
            }
    });
}

}  // namespace vdbcloud
