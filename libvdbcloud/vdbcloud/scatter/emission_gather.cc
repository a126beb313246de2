#include "vdbcloud/scatter/emission_gather.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/p1_problem.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double deepest = 30;    // e^-30 = 1e-13 of the light is left
constexpr double thickest = 2.5;  // visible thickness above which the node's children stand for it
constexpr double smooth = 0.1;    // share of the receivers' light times its change by the depths of a node's children
constexpr int least_edge = 4;     // of a node whose children's depths are compared [voxels]
constexpr double kink = 0.04;     // share of a node times the change of extinction that every receiver's depth needs
constexpr double shown = 0.05;    // share of a node whose own extinction is taken by parts
constexpr double least_share = 1e-6;  // of a node that counts
constexpr int least_gap = 2;          // nearest voxels that a node may hold [voxels]

Vec3d as_double(const Vec3i& v) { return Vec3d(v[0], v[1], v[2]); }

/// sinh(x) / x.
double sinhc(double x) { return x < 0.3 ? 1 + x * x / 6 * (1 + x * x / 20) : std::sinh(x) / x; }

double total(const EmissionNode& node) { return double(node.power[0]) + node.power[1] + node.power[2]; }

/// Receivers from whose depths the depths of the others are interpolated: every n-th. `change`: of extinction among the
/// receivers, times a voxel's edge. The depth has a kink where extinction jumps.
int stride_of(const EmissionNode& node, double share, double change)
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

/// Solid angle of a rectangle seen from a point at the height `z` above its plane; its corners lie at x0..x1, y0..y1
/// from the point's foot.
double rectangle(double x0, double x1, double y0, double y1, double z)
{
    const auto corner = [z](double x, double y) { return std::atan2(x * y, z * std::sqrt(x * x + y * y + z * z)); };
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
}

}  // namespace

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
                for (int z = 0; z < points_[2]; ++z, ++k) {
                    depth_[k] = float(depth_at(Vec3i(x, y, z) * stride_));
                    least_ = std::min(least_, depth_[k]);
                }
    }
    float least() const { return least_; }
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
    float least_ = 1e30f;
    std::array<float, 512> depth_;
};

/// The voxels of a block as receivers.
struct EmissionGather::Voxels {
    Voxels(const EmissionGather& of, size_t block, const BlockMask& wanted, std::vector<double>& to)
        : my(of), b(block), mask(wanted), out(to), first(8 * of.index_.blocks().at(block))
    {
    }

    bool any(const Tile& tile) const
    {
        for (int x = tile.at[0]; x < tile.at[0] + tile.n[0]; ++x)
            for (int y = tile.at[1]; y < tile.at[1] + tile.n[1]; ++y)
                if (mask[size_t(x)] >> (8 * y + tile.at[2]) & ((uint64_t(1) << tile.n[2]) - 1)) return true;
        return false;
    }

    bool take(const EmissionNode& node, const Tile& tile)
    {
        const Look look = my.look(node, tile, scale);
        if (look.share < least_share) return true;
        if (my.coarse(node, tile, look)) return false;
        const bool by_parts = look.parts;
        const TileDepths depths(tile.n, stride_of(node, look.share, change), [&](const Vec3i& p) {
            if (tile.single() && !by_parts) return look.tau;
            const Vec3d at = tile.low + as_double(p);
            return my.depth_(my.index_.world(at), my.way_out(node, at, by_parts), deepest);
        });
        for (int i = 0; i < tile.n[0]; ++i)
            for (int j = 0; j < tile.n[1]; ++j)
                for (int k = 0; k < tile.n[2]; ++k) {
                    const Vec3i p(i, j, k);
                    if (mask[size_t(tile.at[0] + i)] >> (8 * (tile.at[1] + j) + tile.at[2] + k) & 1)
                        add(node, tile, p, depths(p), by_parts);
                }
        return true;
    }

    void add(const EmissionNode& node, const Tile& tile, const Vec3i& p, double tau, bool by_parts)
    {
        const Vec3d& h = my.index_.spacing();
        const View view(node, my.metric(tile.low + as_double(p)), h, tau, by_parts ? &my.parts_ : nullptr);
        const size_t slot = slot_of(tile.at + p);
        double width = 0;
        for (int a = 0; a < 3; ++a) width += std::pow(view.towards[a] * h[a], 2);
        const double thickness = my.sigma_[b * Blocks::size + slot] * std::sqrt(width);
        const double mean = sinhc(thickness / 2), chord = 1 / (1 + thickness * thickness / 12);
        const double swept = chord + diffusive(thickness) * (mean - chord);
        double y[64];
        evaluate_harmonics(my.degree_, -view.towards, y);
        for (size_t c = 0; c < size_t(my.channels_); ++c) {
            const double fluence = view.of_channel(node, c);
            double* to = out.data() + (slot * size_t(my.channels_) + c) * my.values();
            for (int k = 0; k < my.terms_; ++k) to[k] += fluence * swept * y[k];
            to[my.terms_] += fluence * mean;
        }
    }

    /// The 3^3 voxels about a receiver are added once, whichever of them comes first.
    void near(const EmissionNode&, const Tile& tile)
    {
        const size_t slot = slot_of(tile.at);
        if (done[slot / 64] >> (slot % 64) & 1) return;
        done[slot / 64] |= uint64_t(1) << (slot % 64);
        if (sigma.empty()) load();
        NearEmission::Field about, extinction;
        size_t n = 0;
        for (int x = 0; x < 5; ++x)
            for (int y = 0; y < 5; ++y)
                for (int z = 0; z < 5; ++z, ++n) extinction[n] = sigma[apron(tile.at + Vec3i(x, y, z))];
        for (size_t c = 0; c < size_t(my.channels_); ++c) {
            about.fill(0);
            for (int x = 1; x < 4; ++x)
                for (int y = 1; y < 4; ++y)
                    for (int z = 1; z < 4; ++z)
                        about[size_t((x * 5 + y) * 5 + z)] = emission[c][apron(tile.at + Vec3i(x, y, z))];
            double* to = out.data() + (slot * size_t(my.channels_) + c) * my.values();
            double moments[64] = {};
            my.near_.add(about, extinction, moments);
            for (int k = 0; k < my.terms_; ++k) to[k] += moments[k];
            to[my.terms_] += std::sqrt(4 * pi) * moments[0];
        }
    }

    void load()
    {
        sigma.assign(1728, 0);
        for (size_t c = 0; c < size_t(my.channels_); ++c) emission[c].assign(1728, 0);
        const Blocks& blocks = my.index_.blocks();
        for (int x = 0; x < 12; ++x)
            for (int y = 0; y < 12; ++y)
                for (int z = 0; z < 12; ++z) {
                    const size_t slot = blocks.slot(first + Vec3i(x - 2, y - 2, z - 2)), to = apron(Vec3i(x, y, z));
                    if (!blocks.active(slot)) continue;
                    sigma[to] = my.sigma_[slot];
                    for (size_t c = 0; c < size_t(my.channels_); ++c) emission[c][to] = (*my.emission_[c])[slot];
                }
    }

    static size_t slot_of(const Vec3i& at) { return size_t(at[0] * 64 + at[1] * 8 + at[2]); }
    static size_t apron(const Vec3i& at) { return size_t((at[0] * 12 + at[1]) * 12 + at[2]); }

    const EmissionGather& my;
    const size_t b;
    const BlockMask& mask;
    std::vector<double>& out;
    const Vec3i first;
    double scale = 0;          // least fluence of the receivers, roughly
    double change = 0;         // of extinction in the block, times a voxel's edge
    std::vector<float> sigma;  // of the block and two voxels about it; empty until needed
    std::array<std::vector<float>, 3> emission;
    std::array<uint64_t, 8> done{};
};

/// The cells of a plane as receivers: numbered from 0 along the plane's axes, 0 across it.
struct EmissionGather::Plane {
    Plane(const EmissionGather& of, int f, std::vector<double>& to) : my(of), face(f), out(to)
    {
        cells[0] = cells[1] = cells[2] = 1;
        for (const int a : ActiveBox::axes(face / 2)) cells[a] = my.box_.size(a);
    }

    bool inside(const Vec3i& at) const { return at[0] < cells[0] && at[1] < cells[1] && at[2] < cells[2]; }
    bool any(const Tile& tile) const { return inside(tile.at); }
    size_t cell(const Vec3i& at) const { return my.box_.cell(face, my.box_.first + at); }

    /// The depth from a point on the way from `source` to a place of the plane, and on to the end of the trilinear
    /// fringe.
    double depth(const Vec3d& source, const Vec3d& place, const Vec3d& from) const  // `from` [world]
    {
        const Vec3d way = place - source;
        const double across = std::max(std::abs(way[face / 2]), 1e-3);
        return my.depth_(my.index_.world(place + way * (0.5 / across)), from, deepest);
    }

    bool take(const EmissionNode& node, const Tile& tile)
    {
        const int axis = face / 2;
        const Look look = my.look(node, tile, scale);
        if (look.share < least_share) return true;
        if (my.coarse(node, tile, look)) return false;
        const bool by_parts = look.parts;
        const Vec3d centre = my.voxels(Vec3d(node.centre));
        const TileDepths depths(tile.n, stride_of(node, look.share, 0), [&](const Vec3i& p) {
            const Vec3d at = tile.low + as_double(p);
            return depth(centre, at, my.way_out(node, at, by_parts));
        });
        for (int i = 0; i < tile.n[0]; ++i)
            for (int j = 0; j < tile.n[1]; ++j)
                for (int k = 0; k < tile.n[2]; ++k) {
                    const Vec3i p(i, j, k);
                    if (!inside(tile.at + p)) continue;
                    const View view(node, my.metric(tile.low + as_double(p)), my.index_.spacing(), depths(p),
                                    by_parts ? &my.parts_ : nullptr);
                    const double cosine = std::abs(view.towards[axis]);
                    for (size_t c = 0; c < size_t(my.channels_); ++c)
                        out[cell(tile.at + p) * size_t(my.channels_) + c] += cosine * view.of_channel(node, c);
                }
        return true;
    }

    /// A voxel beside the plane, as 3^3 points: the power of each through the cell, by the cell's solid angle.
    void near(const EmissionNode& node, const Tile& tile)
    {
        const Vec3d& h = my.index_.spacing();
        const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        double share = 0;
        for (int k = 0; k < 27; ++k) {
            const Vec3d source = as_double(node.low) + Vec3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1) / 3.0;
            const Vec3d way = tile.low - source;
            const double solid = rectangle((way[u] - 0.5) * h[u], (way[u] + 0.5) * h[u], (way[v] - 0.5) * h[v],
                                           (way[v] + 0.5) * h[v], std::abs(way[axis]) * h[axis]);
            share += solid * std::exp(-depth(source, tile.low, my.index_.world(source))) / 27;
        }
        for (size_t c = 0; c < size_t(my.channels_); ++c)
            out[cell(tile.at) * size_t(my.channels_) + c] += share * node.power[c] / (h[u] * h[v]);
    }

    const EmissionGather& my;
    const int face;
    std::vector<double>& out;
    Vec3i cells;
    double scale = 0;  // as of Voxels
};

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

void EmissionGather::block(size_t block, const BlockMask& wanted, std::vector<double>& out) const
{
    out.assign(size_t(Blocks::size) * size_t(channels_) * values(), 0.0);
    if (tree_.nodes().empty()) return;
    Voxels voxels(*this, block, wanted, out);
    const Vec3d low = as_double(voxels.first);
    const Tile tile{Vec3i(0, 0, 0), Vec3i(8, 8, 8), low, low + Vec3d(7.0)};
    if (!voxels.any(tile)) return;
    voxels.scale = least_fluence(tile);
    const auto [least, most] = std::minmax_element(sigma_.begin() + ptrdiff_t(block * Blocks::size),
                                                   sigma_.begin() + ptrdiff_t((block + 1) * Blocks::size));
    voxels.change = (*most - *least) * std::cbrt(index_.spacing()[0] * index_.spacing()[1] * index_.spacing()[2]);
    descend(tile, {0}, voxels);
}

std::vector<double> EmissionGather::plane(int face) const
{
    std::vector<double> out(box_.cells(face) * size_t(channels_), 0.0);
    if (tree_.nodes().empty()) return out;
    const int axis = face / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    const int rows = (box_.size(u) + 7) / 8, columns = (box_.size(v) + 7) / 8;
    tbb::parallel_for(0, rows * columns, [&, u = u, v = v](int n) {
        Plane plane(*this, face, out);
        Tile tile;
        tile.at = Vec3i(0, 0, 0);
        tile.at[u] = n / columns * 8;
        tile.at[v] = n % columns * 8;
        tile.n = Vec3i(8, 8, 8);
        tile.n[axis] = 1;
        tile.low = as_double(box_.first + tile.at);
        tile.low[axis] = face % 2 ? box_.last[axis] + 0.5 : box_.first[axis] - 0.5;
        tile.high = tile.low + as_double(tile.n - Vec3i(1));
        plane.scale = least_fluence(tile);
        descend(tile, {0}, plane);
    });
    return out;
}

}  // namespace vdbcloud
