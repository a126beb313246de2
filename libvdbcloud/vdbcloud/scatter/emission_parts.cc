#include "vdbcloud/scatter/emission_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr size_t most_parts = 160;
constexpr double deepest = 30;
constexpr int cells = 8;  // of a face of the cube, along an edge; even, so that axes and corners are vertices
constexpr int vertices = cells + 1;

double total(const EmissionNode& node) { return double(node.power[0]) + node.power[1] + node.power[2]; }
double sinhc(double x) { return x < 0.3 ? 1 + x * x / 6 * (1 + x * x / 20) : std::sinh(x) / x; }

}  // namespace

EmissionParts::EmissionParts(const VoxelIndex& index, const EmissionTree& tree, const SegmentDepth& depth)
    : index_(index), tree_(tree), depth_(depth), nodes_(new Node[tree.nodes().size()])
{
}

Vec3d EmissionParts::world(const Vec3d& metric) const
{
    Vec3d voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = metric[a] / index_.spacing()[a];
    return index_.world(voxel);
}

double EmissionParts::reach(const EmissionNode& node) const
{
    double square = 0;
    for (int a = 0; a < 3; ++a) square += std::pow((double(node.high[a]) - node.low[a] + 3) * index_.spacing()[a], 2);
    return std::sqrt(square) / 2;
}

Vec3d EmissionParts::way_out(const EmissionNode& node, const Vec3d& from, const Vec3d& towards) const
{
    return from + towards * (reach(node) - towards.dot(from - Vec3d(node.centre)));
}

void EmissionParts::start(const EmissionNode& node, Node& to) const
{
    std::vector<const EmissionNode*> coarse{&node};
    while (!coarse.empty()) {  // level by level, so that parts are alike
        std::vector<const EmissionNode*> fine;
        for (size_t n = 0; n < coarse.size(); ++n) {
            const EmissionNode& part = *coarse[n];
            const size_t count = to.parts.size() + fine.size() + coarse.size() - n + size_t(part.count);
            if (part.single() || part.sigma * part.size < thin || count > most_parts)
                to.parts.push_back(&part);
            else
                for (int32_t k = 0; k < part.count; ++k) fine.push_back(&tree_.nodes()[size_t(part.first + k)]);
        }
        coarse = std::move(fine);
    }
    to.value = std::make_unique<std::atomic<float>[]>(6 * vertices * vertices);
    for (int n = 0; n < 6 * vertices * vertices; ++n)
        to.value[size_t(n)].store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
}

double EmissionParts::at(const EmissionNode& node, const Node& own, const Vec3d& towards) const
{
    double sum = 0;
    for (const EmissionNode* part : own.parts) {
        // A voxel emits from a tent twice its width, of variance h^2 / 6: as four points at the corners of a
        // tetrahedron.
        static constexpr int corner[4] = {0, 3, 5, 6};
        double mean = 0;
        const int points = part->single() ? 4 : 1;
        for (int k = 0; k < points; ++k) {
            Vec3d from(part->centre);
            for (int a = 0; a < 3 && points > 1; ++a)
                from[a] += (corner[k] >> a & 1 ? 1 : -1) * index_.spacing()[a] / std::sqrt(6.0);
            mean += std::exp(-depth_(world(from), world(way_out(node, from, towards)), deepest)) / points;
        }
        const double x = part->single() ? 0 : part->sigma * part->size / 2;
        sum += total(*part) / total(node) * sinhc(x) * mean;
    }
    return -std::log(std::max(sum, 1e-30));
}

double EmissionParts::operator()(const EmissionNode& node, const Vec3d& towards) const
{
    Node& own = nodes_[size_t(&node - tree_.nodes().data())];
    std::call_once(own.once, [&] { start(node, own); });
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(towards[a]) > std::abs(towards[axis])) axis = a;
    const int across[2] = {(axis + 1) % 3, (axis + 2) % 3}, face = 2 * axis + (towards[axis] > 0);
    int base[2];
    double part[2];
    for (int k = 0; k < 2; ++k) {
        const double place = (towards[across[k]] / std::abs(towards[axis]) + 1) * cells / 2;
        base[k] = std::clamp(int(place), 0, cells - 1);
        part[k] = place - base[k];
    }
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        const int u = base[0] + (k & 1), v = base[1] + (k >> 1);
        std::atomic<float>& value = own.value[size_t((face * vertices + u) * vertices + v)];
        float depth = value.load(std::memory_order_relaxed);
        if (std::isnan(depth)) {
            Vec3d vertex;
            vertex[axis] = towards[axis] > 0 ? 1 : -1;
            vertex[across[0]] = 2.0 * u / cells - 1;
            vertex[across[1]] = 2.0 * v / cells - 1;
            depth = float(at(node, own, vertex.unit()));
            value.store(depth, std::memory_order_relaxed);
        }
        sum += (k & 1 ? part[0] : 1 - part[0]) * (k >> 1 ? part[1] : 1 - part[1]) * depth;
    }
    return sum;
}

}  // namespace vdbcloud
