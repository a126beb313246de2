#include "vdbcloud/solve/aggregation.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr float strong = 0.4f;    // of the strongest link of either end: joins voxels
constexpr double worst_pair = 9;  // condition number of a pair of sets that is still joined
constexpr double held = 1.0 / 3;  // extra of at least this part of the links needs no coarser level

/// A set of unknowns: sums of the diagonal and of extra.
struct Set {
    double mass, extra;
};

double side(double a, double b) { return a > 0 && b > 0 ? a * b / (a + b) : 0.0; }

/// Condition number of joining two sets that are linked by c.
double quality(const Set& i, const Set& j, double c) { return 2 * side(i.mass, j.mass) / (c + side(i.extra, j.extra)); }

/// Voxels of a cell of 2x2x2, bit 2 for x, 1 for y, 0 for z, as offsets in a block.
constexpr int corner(int k) { return (k >> 2) * 64 + (k >> 1 & 1) * 8 + (k & 1); }

/// The strongest link of each voxel of a block, -1 where extra holds it.
VDBCLOUD_CLONES void strongest_links(const StencilArrays& a, size_t block, float* most)
{
    const auto larger = [](const Floats& u, const Floats& v) __attribute__((always_inline)) { return u > v ? u : v; };
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const RowLinks c = row_links(a, block, x, y);
            const Floats linked = ((c.xm + c.xp) + (c.ym + c.yp)) + (c.zm + c.zp);
            const Floats strongest = larger(larger(larger(c.xm, c.xp), larger(c.ym, c.yp)), larger(c.zm, c.zp));
            const size_t row = size_t(x * 64 + y * 8);
            const Floats extra = load(a.extra + block * 512 + row);
            store(most + row, extra >= all(float(held)) * linked ? all(-1.0f) : strongest);
        }
}

/// Groups of one block; returns how many.
int group_block(const Stencil& a, const StencilArrays& arrays, size_t block, uint16_t* of)
{
    const size_t base = block * Blocks::size;
    alignas(32) float most[Blocks::size];  // strongest link of a voxel that takes part, -1 of others
    strongest_links(arrays, block, most);
    for (size_t i = 0; i < Blocks::size; ++i)
        if (!(a.blocks->mask(block)[i / 64] >> (i % 64) & 1)) most[i] = -1;
    int count = 0;
    for (int cell = 0; cell < 64; ++cell) {
        const int at = 2 * (cell >> 4) * 64 + 2 * (cell >> 2 & 3) * 8 + 2 * (cell & 3);
        int lowest[8] = {0, 1, 2, 3, 4, 5, 6, 7};
        for (int bit : {1, 2, 4})
            for (int k = 0; k < 8; ++k) {
                const int i = at + corner(k), j = at + corner(k | bit);
                if (k & bit || most[i] < 0 || most[j] < 0) continue;
                const float c = a.face[bit == 4 ? 0 : bit == 2 ? 1 : 2][base + size_t(i)];
                if (!(c > 0) || c < strong * std::max(most[i], most[j])) continue;
                const auto [low, high] = std::minmax(lowest[k], lowest[k | bit]);
                std::replace(lowest, lowest + 8, int(high), int(low));
            }
        for (int k = 0; k < 8; ++k) {
            uint16_t& group = of[at + corner(k)];
            if (most[at + corner(k)] < 0)
                group = VoxelGroups::none;
            else
                group = lowest[k] == k ? uint16_t(count++) : of[at + corner(lowest[k])];
        }
    }
    return count;
}

/// One round of pairing. `set` are the masses and extras, summed over what was fine; returns the number of groups.
size_t pair_up(const Graph& graph, const std::vector<Set>& set, const std::vector<char>& left_out,
               std::vector<int32_t>& group)
{
    int32_t count = 0;
    group.assign(graph.size(), -1);
    for (size_t i = 0; i < graph.size(); ++i) {
        if (group[i] >= 0 || left_out[i]) continue;
        double best = worst_pair;
        int32_t with = -1;
        for (uint32_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
            const int32_t j = graph.column[k];
            if (group[size_t(j)] >= 0 || left_out[size_t(j)]) continue;
            const double q = quality(set[i], set[size_t(j)], graph.c[k]);
            if (q > best || (q == best && with >= 0)) continue;
            best = q;
            with = j;
        }
        group[i] = count;
        if (with >= 0) group[size_t(with)] = count;
        ++count;
    }
    return size_t(count);
}

}  // namespace

VoxelGroups group_voxels(const Stencil& a)
{
    const size_t count = a.blocks->count();
    VoxelGroups groups;
    groups.of.resize(a.blocks->slots(), VoxelGroups::none);
    groups.first.assign(count + 1, 0);
    const StencilArrays arrays = arrays_of(a);
    for_ranges(count, [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block)
            groups.first[block + 1] = group_block(a, arrays, block, groups.of.data() + block * Blocks::size);
    });
    for (size_t block = 0; block < count; ++block) groups.first[block + 1] += groups.first[block];
    return groups;
}

namespace {

/// Links of one group of voxels: at most 24 outward faces and the other groups of its cell.
struct Links {
    int count = 0;
    int32_t column[32];
    double c[32];

    void add(int32_t to, float by)
    {
        int k = 0;
        while (k < count && column[k] != to) ++k;
        if (k == count) {
            column[count] = to;
            c[count++] = 0;
        }
        c[k] += by;
    }
};

}  // namespace

Graph collapsed(const Stencil& a, const VoxelGroups& groups)
{
    const Blocks& blocks = *a.blocks;
    constexpr size_t at_once = 64;
    std::vector<Graph> parts((blocks.count() + at_once - 1) / at_once);
    for_each(parts.size(), [&](size_t part) {
        std::vector<Links> links(Blocks::size);
        double extra[Blocks::size];
        for (size_t block = part * at_once; block < std::min(blocks.count(), (part + 1) * at_once); ++block) {
            const size_t rows = size_t(groups.first[block + 1] - groups.first[block]);
            std::fill(extra, extra + rows, 0.0);
            for (size_t row = 0; row < rows; ++row) links[row].count = 0;
            for (size_t slot = block * Blocks::size; slot < (block + 1) * Blocks::size; ++slot) {
                const uint16_t row = groups.of[slot];
                if (row == VoxelGroups::none) continue;
                extra[row] += a.extra[slot];
                for (int face = 0; face < 6; ++face) {
                    const size_t to = beside(blocks, slot, face);
                    const float c = a.face[face / 2][face % 2 ? slot : to];
                    if (!(c > 0)) continue;
                    const int32_t column = groups(to);
                    if (column < 0)
                        extra[row] += c;
                    else if (column != groups.first[block] + row)
                        links[row].add(column, c);
                }
            }
            for (size_t row = 0; row < rows; ++row) {
                for (int k = 0; k < links[row].count; ++k) parts[part].add_link(links[row].column[k], links[row].c[k]);
                parts[part].end_row(extra[row]);
            }
        }
    });
    return joined(parts);
}

Graph grouped(const Graph& fine, std::vector<int32_t>& group)
{
    std::vector<Set> set(fine.size());
    std::vector<char> left_out(fine.size(), 0);
    for (size_t i = 0; i < fine.size(); ++i) {
        const double linked = fine.linked(i);
        set[i] = {linked + fine.extra[i], fine.extra[i]};
        left_out[i] = fine.extra[i] >= held * linked;
    }
    Graph coarse;
    for (int round = 0; round < 3; ++round) {
        const Graph& from = round ? coarse : fine;
        std::vector<int32_t> pair;
        const size_t count = pair_up(from, set, left_out, pair);
        Graph next = collapsed(from, pair, count);
        std::vector<Set> sums(count, Set{0, 0});
        for (size_t i = 0; i < pair.size(); ++i)
            if (pair[i] >= 0) {
                Set& to = sums[size_t(pair[i])];
                to = {to.mass + set[i].mass, to.extra + set[i].extra};
            }
        if (round == 0)
            group = std::move(pair);
        else
            for (int32_t& g : group)
                if (g >= 0) g = pair[size_t(g)];
        set = std::move(sums);
        left_out.assign(count, 0);
        coarse = std::move(next);
    }
    return coarse;
}

}  // namespace vdbcloud
