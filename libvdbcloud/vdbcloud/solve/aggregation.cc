#include "vdbcloud/solve/aggregation.h"

#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

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

/// Groups of one block; returns how many.
int group_block(const Stencil& a, size_t block, uint16_t* of)
{
    const Blocks& blocks = *a.blocks;
    const size_t base = block * Blocks::size;
    float most[Blocks::size];  // strongest link of a voxel that takes part, -1 of others
    for (size_t i = 0; i < Blocks::size; ++i) {
        const size_t slot = base + i;
        float linked = 0;
        most[i] = 0;
        for (int axis = 0; axis < 3; ++axis)
            for (const float c : {a.face[axis][slot], a.face[axis][beside(blocks, slot, 2 * axis)]}) {
                most[i] = std::max(most[i], c);
                linked += c;
            }
        if (!blocks.active(slot) || a.extra[slot] >= float(held) * linked) most[i] = -1;
    }
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
    for_ranges(count, [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block)
            groups.first[block + 1] = group_block(a, block, groups.of.data() + block * Blocks::size);
    });
    for (size_t block = 0; block < count; ++block) groups.first[block + 1] += groups.first[block];
    return groups;
}

Graph collapsed(const Stencil& a, const VoxelGroups& groups)
{
    const Blocks& blocks = *a.blocks;
    constexpr size_t at_once = 64;
    std::vector<Graph> parts((blocks.count() + at_once - 1) / at_once);
    for_each(parts.size(), [&](size_t part) {
        std::vector<std::vector<std::pair<int32_t, float>>> links(Blocks::size);
        double extra[Blocks::size];
        for (size_t block = part * at_once; block < std::min(blocks.count(), (part + 1) * at_once); ++block) {
            const size_t rows = size_t(groups.first[block + 1] - groups.first[block]);
            std::fill(extra, extra + rows, 0.0);
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
                        links[row].emplace_back(column, c);
                }
            }
            for (size_t row = 0; row < rows; ++row) parts[part].add_row(links[row], extra[row]);
        }
    });
    Graph graph;
    for (Graph& part : parts) {
        graph.append(part);
        part = {};
    }
    return graph;
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
