#pragma once
// What the two kinds of receivers of EmissionGather share: voxels (emission_voxels.cc) and planes (emission_planes.cc).
// Private to scatter/.
#include "vdbcloud/scatter/emission_gather.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace emission {

inline constexpr double deepest = 30;  ///< e^-30 = 1e-13 of the light is left
/// Share of a node times the change of extinction that every receiver's depth needs.
inline constexpr double kink = 0.04;
inline constexpr double least_share = 1e-6;  ///< of a node that counts

inline Vec3d as_double(const Vec3i& v) { return Vec3d(v[0], v[1], v[2]); }

/// sinh(x) / x.
inline double sinhc(double x) { return x < 0.3 ? 1 + x * x / 6 * (1 + x * x / 20) : std::sinh(x) / x; }

/// Receivers from whose depths the depths of the others are interpolated: every n-th. `change`: of extinction among the
/// receivers, times a voxel's edge. The depth has a kink where extinction jumps.
inline int stride_of(const EmissionNode& node, double share, double change)
{
    if (share * change > kink) return 1;
    const int of_size = node.edge() < 4 ? 1 : node.edge() < 16 ? 2 : 4;
    return std::max(of_size, share > 0.05 ? 1 : share > 0.02 ? 2 : share > 0.005 ? 4 : 8);
}

/// A node as a receiver sees it.
struct View {
    Vec3d towards;          ///< unit, along the index axes
    double fluence = 0;     ///< of unit power
    double per_offset = 0;  ///< relative change for a source this much further away [1/world unit]

    /// `tau`: the depth up to the node's mean position, or with `parts` up to the node's reach.
    View(const EmissionNode& node, const Vec3d& from, const Vec3d& spacing, double tau, const EmissionParts* parts)
    {
        towards = Vec3d(node.centre) - from;
        const double r = towards.length();
        towards /= r;
        const Vec3d& s = towards;
        const auto& c = node.spread;
        const double along = c[0] * s[0] * s[0] + c[1] * s[1] * s[1] + c[2] * s[2] * s[2] +
                             2 * (c[3] * s[0] * s[1] + c[4] * s[0] * s[2] + c[5] * s[1] * s[2]);
        double trilinear = 0, all = 0;  // light is emitted by a tent about each centre, twice as wide as the voxel
        for (int a = 0; a < 3; ++a) {
            all += spacing[a] * spacing[a] / 12 + c[size_t(a)];
            trilinear += spacing[a] * spacing[a] / 12 * s[a] * s[a];
        }
        const double x = std::sqrt(3 * along) * node.sigma;
        const double nearer = r - std::sqrt(3 * along) * x / (3 + x);
        const double shape = (4 * (along + trilinear) - all) / (nearer * nearer);
        const double own = parts ? std::exp(-tau - (*parts)(node, -towards)) : std::exp(-tau) * sinhc(x);
        fluence = own * (1 + shape) / (nearer * nearer);
        per_offset = node.sigma + 2 / nearer;
    }

    double of_channel(const EmissionNode& node, size_t c) const
    {
        const double further = towards.dot(Vec3d(node.offset[c]));
        return node.power[c] * fluence * std::max(1 - per_offset * further, 0.0);
    }
};

}  // namespace emission

/// A node as a tile sees it.
struct EmissionGather::Look {
    double share = 0;      ///< of the light in the tile's middle
    double tau = 0;        ///< depth from there to the mean position
    double thickness = 0;  ///< optical size, less where the depth up to the node hides it
    bool parts = false;    ///< the node's own extinction is taken part by part
};

/// A box of receivers at `first` + (0..n-1) by axis. Edges are powers of two.
struct EmissionGather::Tile {
    Vec3i at;  ///< of the first receiver in the sink's own numbering
    Vec3i n;
    Vec3d low, high;  ///< first and last receiver [voxels]
    bool single() const { return n[0] * n[1] * n[2] == 1; }
    int edge() const { return std::max({n[0], n[1], n[2]}); }
};

/// Depths from a node to the receivers of a tile.
class EmissionGather::TileDepths {
public:
    /// `depth_at(p)`: from the node to the point at `p` from the tile's first receiver [voxels].
    template<typename DepthAt>
    TileDepths(const Vec3i& n, int stride, const DepthAt& depth_at)
        : stride_(std::min(stride, std::max({n[0], n[1], n[2]})))
    {
        for (int a = 0; a < 3; ++a) points_[a] = n[a] == 1 ? 1 : stride_ == 1 ? n[a] : n[a] / stride_ + 1;
        size_t k = 0;
        for (int x = 0; x < points_[0]; ++x)
            for (int y = 0; y < points_[1]; ++y)
                for (int z = 0; z < points_[2]; ++z, ++k) depth_[k] = float(depth_at(Vec3i(x, y, z) * stride_));
    }
    double operator()(const Vec3i& p) const
    {
        if (stride_ == 1) return at(p[0], p[1], p[2]);
        int base[3];
        double part[3];
        for (int a = 0; a < 3; ++a) {
            base[a] = p[a] / stride_;
            part[a] = double(p[a] % stride_) / stride_;
        }
        double sum = 0;
        for (int k = 0; k < 8; ++k) {
            double weight = 1;
            int q[3];
            for (int a = 0; a < 3; ++a) {
                const int up = k >> a & 1;
                weight *= up ? part[a] : 1 - part[a];
                q[a] = std::min(base[a] + up, points_[a] - 1);
            }
            if (weight > 0) sum += weight * at(q[0], q[1], q[2]);
        }
        return sum;
    }

private:
    double at(int x, int y, int z) const { return depth_[size_t((x * points_[1] + y) * points_[2] + z)]; }

    int stride_ = 8, points_[3] = {1, 1, 1};
    std::array<float, 512> depth_;
};

/// Gives `sink` the nodes that stand for their voxels, for the tile or its parts.
template<typename Sink>
void EmissionGather::descend(const Tile& tile, const std::vector<int32_t>& nodes, Sink& sink) const
{
    std::vector<int32_t> open(nodes), deferred;
    while (!open.empty()) {
        const int32_t id = open.back();
        const EmissionNode& node = tree_.nodes()[size_t(id)];
        open.pop_back();
        const bool far = apart(node, tile.low, tile.high) &&
                         (node.size <= distance(node, tile.low, tile.high) || (node.single() && tile.single()));
        if (far && sink.take(node, tile)) continue;
        if (node.single() && tile.single())
            sink.near(node, tile);
        else if (!node.single() && (far || tile.single() || node.edge() >= tile.edge())) {
            for (int32_t n = node.count; n-- > 0;) open.push_back(node.first + n);
        } else
            deferred.push_back(id);
    }
    if (deferred.empty()) return;
    const int halves[3] = {tile.n[0] > 1 ? 2 : 1, tile.n[1] > 1 ? 2 : 1, tile.n[2] > 1 ? 2 : 1};
    for (int x = 0; x < halves[0]; ++x)
        for (int y = 0; y < halves[1]; ++y)
            for (int z = 0; z < halves[2]; ++z) {
                Tile part = tile;
                const int up[3] = {x, y, z};
                for (int a = 0; a < 3; ++a) {
                    part.n[a] /= halves[a];
                    part.at[a] += up[a] * part.n[a];
                    part.low[a] += up[a] * part.n[a];
                    part.high[a] = part.low[a] + part.n[a] - 1;
                }
                if (sink.any(part)) descend(part, deferred, sink);
            }
}

}  // namespace vdbcloud
