#include "vdbcloud/scatter/emission_receivers.h"

#include "vdbcloud/optics/spherical_harmonics.h"

#include <limits>

namespace vdbcloud {

using namespace emission;

namespace {

constexpr double thickest = 2.5;  // visible thickness above which the node's children stand for it
constexpr double smooth = 0.1;    // share of the receivers' light times its change by the depths of a node's children
constexpr int least_edge = 4;     // of a node whose children's depths are compared [voxels]
constexpr double shown = 0.05;    // share of a node whose own extinction is taken by parts
constexpr int least_gap = 2;      // nearest voxels that a node may hold [voxels]

double total(const EmissionNode& node) { return double(node.power[0]) + node.power[1] + node.power[2]; }

}  // namespace

EmissionGather::EmissionGather(const VoxelIndex& index, const EmissionTree& tree,
                               const std::vector<const std::vector<float>*>& emission, const SegmentDepth& depth,
                               const std::vector<float>& sigma, int degree, double opening)
    : index_(index), tree_(tree), emission_(emission), depth_(depth), sigma_(sigma), degree_(degree),
      terms_(harmonic_count(degree)), channels_(tree.channels()), opening_(opening), near_(index.spacing(), degree),
      parts_(index, tree, depth), box_(index.blocks())
{
}

Vec3d EmissionGather::metric(const Vec3d& voxel) const
{
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = voxel[a] * index_.spacing()[a];
    return p;
}

Vec3d EmissionGather::voxels(const Vec3d& metric) const
{
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = metric[a] / index_.spacing()[a];
    return p;
}

double EmissionGather::fluence(const EmissionNode& node, const Vec3d& receiver, double& tau) const
{
    const Vec3d centre(node.centre);
    const double least = 0.5 * node.size, distance = std::max((metric(receiver) - centre).length(), least);
    tau = depth_(index_.world(receiver), index_.world(voxels(centre)), deepest);
    return total(node) * std::exp(-tau) * sinhc(std::min(double(node.sigma) * node.size, 2 * tau) / 2) /
           (distance * distance);
}

EmissionGather::Look EmissionGather::look(const EmissionNode& node, const Tile& tile, double scale) const
{
    double tau = 0;
    Look look;
    look.share = std::min(fluence(node, (tile.low + tile.high) / 2, tau) / scale, 1.0);
    const double x = double(node.sigma) * node.size;
    look.tau = tau;
    look.thickness = x * std::max(look.share, std::exp(-std::max(tau - x / 2, 0.0) / 2));
    look.parts = !node.single() && look.thickness > EmissionParts::thin && look.share > shown &&
                 parts_.reach(node) < (metric((tile.low + tile.high) / 2) - Vec3d(node.centre)).length() / 1.5;
    return look;
}

double EmissionGather::least_fluence(const Tile& tile) const
{
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 5; ++k) {  // the middle and four corners
        static constexpr int corner[4] = {0, 3, 5, 6};
        Vec3d receiver = (tile.low + tile.high) / 2;
        for (int a = 0; a < 3 && k > 0; ++a) receiver[a] = corner[k - 1] >> a & 1 ? tile.high[a] : tile.low[a];
        double sum = 0, tau = 0;
        std::vector<int32_t> open{0};
        while (!open.empty()) {
            const EmissionNode& node = tree_.nodes()[size_t(open.back())];
            open.pop_back();
            if (node.single() || node.size <= (metric(receiver) - Vec3d(node.centre)).length())
                sum += fluence(node, receiver, tau);
            else
                for (int32_t n = 0; n < node.count; ++n) open.push_back(node.first + n);
        }
        least = std::min(least, sum);
    }
    return std::max(least, 1e-300);
}

Vec3d EmissionGather::way_out(const EmissionNode& node, const Vec3d& receiver, bool by_parts) const
{
    const Vec3d centre(node.centre);
    return index_.world(voxels(by_parts ? parts_.way_out(node, centre, (metric(receiver) - centre).unit()) : centre));
}

bool EmissionGather::coarse(const EmissionNode& node, const Tile& tile, const Look& look) const
{
    if (node.single() && tile.single()) return false;
    const double nearness = node.size / distance(node, tile.low, tile.high);
    if ((nearness > opening_ || look.parts) && look.share * nearness * nearness > (look.parts ? 0.3 : 1) * smooth)
        return true;
    if (node.single()) return false;
    if (look.thickness > thickest && look.share > 0.01) return true;
    if (node.edge() < least_edge || look.share < smooth / 2) return false;
    const bool by_parts = look.parts;
    const Vec3d receiver = (tile.low + tile.high) / 2, there = index_.world(receiver),
                towards = (metric(receiver) - Vec3d(node.centre)).unit();
    double sum = 0, whole = 0;
    for (int32_t k = 0; k < node.count; ++k) {
        const EmissionNode& part = tree_.nodes()[size_t(node.first + k)];
        const Vec3d centre(part.centre), from = by_parts ? parts_.way_out(node, centre, towards) : centre;
        sum += total(part) * std::exp(-depth_(there, parts_.world(from), deepest));
        whole += total(part);
    }
    const double middle = depth_(there, way_out(node, receiver, by_parts), deepest);
    return look.share * std::abs(std::log(std::max(sum / whole, 1e-30)) + middle) > smooth;
}

bool EmissionGather::apart(const EmissionNode& node, const Vec3d& low, const Vec3d& high) const
{
    for (int a = 0; a < 3; ++a)
        if (node.low[a] - high[a] >= least_gap || low[a] - node.high[a] >= least_gap) return true;
    return false;
}

double EmissionGather::distance(const EmissionNode& node, const Vec3d& low, const Vec3d& high) const
{
    const Vec3d lo = metric(low), hi = metric(high);
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double d = std::max({lo[a] - node.centre[a], node.centre[a] - hi[a], 0.0});
        square += d * d;
    }
    return std::sqrt(square);
}

}  // namespace vdbcloud
