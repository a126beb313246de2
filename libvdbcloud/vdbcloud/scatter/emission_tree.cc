#include "vdbcloud/scatter/emission_tree.h"

#include <algorithm>

namespace vdbcloud {

namespace {

struct Emitter {
    Vec3i voxel;
    size_t slot;
};

struct Range {
    size_t node, begin, end;
};

/// Pairs of axes of a covariance's six numbers.
constexpr int first_axis[6] = {0, 1, 2, 0, 0, 1}, second_axis[6] = {0, 1, 2, 1, 2, 2};

double total(const std::array<float, 3>& power) { return double(power[0]) + power[1] + power[2]; }

/// Sorts the emitters of a node by the parts that they belong to, and returns the parts that are not empty. (A node of
/// more than one voxel is more than one voxel wide across an edge that is halved, unless voxels are flat: then across
/// the edge of most voxels.)
std::vector<Range> parts_of(const EmissionNode& node, const Vec3d& spacing, std::vector<Emitter>& emitters,
                            const Range& range)
{
    Vec3i middle = node.high;
    bool halved = false;
    for (int a = 0; a < 3; ++a) {
        const int last = node.high[a] - node.low[a];
        if (last == 0 || 2 * (last + 1.0) * spacing[a] <= node.size) continue;
        middle[a] = node.low[a] + last / 2;
        halved = true;
    }
    for (int a = 0; a < 3 && !halved; ++a)
        if (node.high[a] - node.low[a] + 1 == node.edge()) {
            middle[a] = node.low[a] + (node.edge() - 1) / 2;
            halved = true;
        }
    const auto part = [&](const Emitter& e) {
        return (e.voxel[0] > middle[0]) * 4 + (e.voxel[1] > middle[1]) * 2 + (e.voxel[2] > middle[2]);
    };
    const auto begin = emitters.begin() + ptrdiff_t(range.begin), end = emitters.begin() + ptrdiff_t(range.end);
    std::stable_sort(begin, end, [&](const Emitter& p, const Emitter& q) { return part(p) < part(q); });
    std::vector<Range> parts;
    for (size_t n = range.begin; n < range.end; ++n) {
        if (parts.empty() || part(emitters[n]) != part(emitters[n - 1])) parts.push_back({0, n, n});
        ++parts.back().end;
    }
    return parts;
}

}  // namespace

EmissionTree::EmissionTree(const VoxelIndex& index, const std::vector<const std::vector<float>*>& emission,
                           const std::vector<float>& sigma)
    : channels_(int(emission.size()))
{
    const Blocks& blocks = index.blocks();
    const Vec3d& h = index.spacing();
    std::vector<Emitter> emitters;
    for (size_t slot = 0; slot < blocks.count() * Blocks::size; ++slot) {
        const bool emits = std::any_of(emission.begin(), emission.end(), [&](const auto* j) { return (*j)[slot] > 0; });
        if (emits && blocks.active(slot)) emitters.push_back({blocks.voxel(slot), slot});
    }
    if (emitters.empty()) return;
    nodes_.reserve(2 * emitters.size());
    nodes_.emplace_back();
    std::vector<Range> open{{0, 0, emitters.size()}};
    while (!open.empty()) {
        const Range range = open.back();
        open.pop_back();
        EmissionNode node;
        node.low = node.high = emitters[range.begin].voxel;
        for (size_t n = range.begin; n < range.end; ++n)
            for (int a = 0; a < 3; ++a) {
                node.low[a] = std::min(node.low[a], emitters[n].voxel[a]);
                node.high[a] = std::max(node.high[a], emitters[n].voxel[a]);
            }
        for (int a = 0; a < 3; ++a) node.size = std::max(node.size, float((node.high[a] - node.low[a] + 1.0) * h[a]));
        if (range.end - range.begin == 1) {
            const size_t slot = emitters[range.begin].slot;
            for (int a = 0; a < 3; ++a) {
                node.centre[a] = node.low[a] * h[a];
                node.spread[size_t(a)] = float(h[a] * h[a] / 12);
            }
            for (size_t c = 0; c < emission.size(); ++c)
                node.power[c] = float((*emission[c])[slot] * h[0] * h[1] * h[2]);
            node.sigma = sigma[slot];
        } else {
            node.first = int32_t(nodes_.size());
            for (const Range& part : parts_of(node, h, emitters, range)) {
                open.push_back({nodes_.size(), part.begin, part.end});
                nodes_.emplace_back();
                ++node.count;
            }
        }
        nodes_[range.node] = node;
    }
    for (size_t n = nodes_.size(); n-- > 0;)  // children have higher numbers
        if (!nodes_[n].single()) merge(nodes_[n]);
}

void EmissionTree::merge(EmissionNode& node) const
{
    double whole = 0, sigma = 0;
    Vec3d centre(0, 0, 0);
    const EmissionNode *begin = &nodes_[size_t(node.first)], *end = begin + node.count;
    for (const EmissionNode* of = begin; of != end; ++of) {
        const double power = total(of->power);
        whole += power;
        sigma += power * of->sigma;
        centre += power * of->centre;
    }
    centre /= whole;
    node.centre = centre;
    node.sigma = float(sigma / whole);
    std::array<double, 6> spread{};
    std::array<Vec3d, 3> moment{Vec3d(0.0), Vec3d(0.0), Vec3d(0.0)};
    for (const EmissionNode* of = begin; of != end; ++of) {
        const double share = total(of->power) / whole;
        const Vec3d apart = of->centre - centre;
        for (size_t k = 0; k < 6; ++k)
            spread[k] += share * (of->spread[k] + apart[first_axis[k]] * apart[second_axis[k]]);
        for (size_t c = 0; c < 3; ++c) {
            node.power[c] += of->power[c];
            moment[c] += double(of->power[c]) * (apart + Vec3d(of->offset[c]));
        }
    }
    for (size_t k = 0; k < 6; ++k) node.spread[k] = float(spread[k]);
    for (size_t c = 0; c < 3; ++c)
        node.offset[c] = node.power[c] > 0 ? Vec3f(moment[c] / double(node.power[c])) : Vec3f(0.0f);
}

}  // namespace vdbcloud
