#include "vdbcloud/sweep/sweep_order.h"

#include "vdbcloud/sweep/patch_light.h"

#include <algorithm>
#include <tuple>

namespace vdbcloud::sweep_order {

std::vector<Pass> passes(int axis, const PatchLight* ground)
{
    std::vector<Pass> all;
    for (int octant = 0; octant < 8; ++octant) {
        const int other = octant | bit_of(axis);
        if (octant == other) continue;
        if (ground && ground->leaves(signs(octant)) != ground->leaves(signs(other)))
            all.insert(all.end(), {{octant}, {other}});
        else
            all.push_back({octant, other});
    }
    if (ground)
        std::stable_partition(all.begin(), all.end(), [&](const Pass& pass) { return ground->leaves(signs(pass[0])); });
    return all;
}

namespace {

/// Sets the places of the blocks. Blocks depend on those of their own level and of the two before.
void set_places(Order& order)
{
    const auto begin = [&](size_t level) { return order.column[order.tile[order.level[level]]]; };
    order.place.resize(order.block.size());
    std::vector<int32_t> free;
    for (size_t level = 0; level + 1 < order.level.size(); ++level) {
        for (size_t n = level < 3 ? 0 : begin(level - 3); level >= 3 && n < begin(level - 2); ++n)
            free.push_back(order.place[size_t(order.block[n])]);
        for (size_t n = begin(level); n < begin(level + 1); ++n) {
            if (free.empty()) free.push_back(int32_t(order.places++));
            order.place[size_t(order.block[n])] = free.back();
            free.pop_back();
        }
    }
}

}  // namespace

Order order_of(const Blocks& blocks, const Sign& sign, int axis, int bits)
{
    struct Keyed {
        int level;
        std::array<int, 2> tile, column;
        int at;
        int32_t block;
        auto key() const { return std::tie(level, tile, column, at); }
        bool operator<(const Keyed& other) const { return key() < other.key(); }
    };
    const int across[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    std::vector<Keyed> keyed(blocks.count());
    for (size_t b = 0; b < blocks.count(); ++b) {
        Keyed& key = keyed[b];
        for (size_t n = 0; n < 2; ++n) {
            key.column[n] = sign[size_t(across[n])] * blocks.at(b)[across[n]];
            key.tile[n] = sign[size_t(across[n])] * (blocks.at(b)[across[n]] >> bits);
        }
        key.level = key.tile[0] + key.tile[1];
        key.at = blocks.at(b)[axis];
        key.block = int32_t(b);
    }
    std::sort(keyed.begin(), keyed.end());
    Order order;
    for (size_t n = 0; n < keyed.size(); ++n) {
        const bool level = n == 0 || keyed[n].level != keyed[n - 1].level;
        const bool tile = level || keyed[n].tile != keyed[n - 1].tile;
        if (level) order.level.push_back(order.tile.size());
        if (tile) order.tile.push_back(order.column.size());
        if (tile || keyed[n].column != keyed[n - 1].column) order.column.push_back(n);
        order.block.push_back(keyed[n].block);
    }
    order.level.push_back(order.tile.size());
    order.tile.push_back(order.column.size());
    order.column.push_back(keyed.size());
    set_places(order);
    return order;
}

std::pair<int, int> axis_and_bits(const Blocks& blocks)
{
    std::pair<int, int> best{2, 0};
    double most = 0;
    for (int bits = 2; bits >= 0; --bits)
        for (int axis = 2; axis >= 0; --axis) {
            const Order order = order_of(blocks, {1, 1, 1}, axis, bits);
            if (order.enough()) return {axis, bits};
            const double a_level = double(order.tile.size()) / double(order.level.size());
            if (a_level > most) best = {axis, bits};
            most = std::max(most, a_level);
        }
    return best;
}

}  // namespace vdbcloud::sweep_order
