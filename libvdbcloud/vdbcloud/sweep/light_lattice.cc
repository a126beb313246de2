#include "vdbcloud/sweep/light_lattice.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/sweep/lattice_frame.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <map>

namespace vdbcloud {

namespace {

constexpr int tile = 32;        // integer ray positions a tile owns along u and v
constexpr int rays = tile + 1;  // and one more, to interpolate towards
constexpr int row = 36;         // rays, padded
constexpr int margin = 4;       // voxels that a plane buffer holds beyond the tile on each side
constexpr int span = rays + 2 * margin + 3;

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }
int ifloor(double x) { return int(std::floor(x)); }

/// The voxels of one plane w about a tile: value (v, u) at value[v * span + u], the first voxel being (v0, u0).
struct Plane {
    int w = 0, u0 = 0, v0 = 0;
    bool valid = false;
    int u_low = span, u_high = -1, v_low = span, v_high = -1;  // of the values that are not 0
    std::array<float, span * span> value;

    bool any() const { return u_high >= u_low; }
    void note(int v, int u)
    {
        u_low = std::min(u_low, u);
        u_high = std::max(u_high, u);
        v_low = std::min(v_low, v);
        v_high = std::max(v_high, v);
    }
};

VDBCLOUD_CLONES void add_scaled(double* sum, const float* x, double weight, int n)
{
    for (int i = 0; i < n; ++i) sum[i] += weight * double(x[i]);
}

/// A tile's rays and their depths, advanced along w.
class Tile {
public:
    Tile(const BrickMap& density, const LatticeFrame& frame, int rays_per_voxel, int a0, int b0)
        : density_(density), f_(frame), r_(rays_per_voxel), a0_(a0), b0_(b0), depth_(size_t(r_) * r_ * rays * row, 0.0)
    {
    }

    /// From plane n - 1 to plane n (planes lie at w = n + frame.ow).
    void step(int n)
    {
        const double w0 = n - 1 + f_.ow;
        const int first = ifloor(w0), last = ifloor(w0 + 1) + 1;
        bool any = false;
        for (int w = first; w <= last; ++w) any = plane(w).any() || any;
        if (!any) return;
        for (int q = 0; q < r_; ++q)
            for (int p = 0; p < r_; ++p)
                for (const auto& tap : step_taps(f_, double(p) / r_ + f_.mu * w0, double(q) / r_ + f_.mv * w0, w0)) {
                    const Plane& from = plane(tap.dw);
                    // Only rays that meet values other than 0: of a brick with one voxel there are few.
                    const int u = a0_ + tap.du - from.u0, v = b0_ + tap.dv - from.v0;
                    const int i = std::max(0, from.u_low - u), count = std::min(rays - 1, from.u_high - u) - i + 1;
                    const int end = std::min(rays - 1, from.v_high - v);
                    for (int j = std::max(0, from.v_low - v); j <= end && count > 0; ++j) {
                        add_scaled(phase(p, q) + j * row + i, from.value.data() + size_t(v + j) * span + u + i,
                                   tap.weight, count);
                        products_ += size_t(count);
                    }
                }
    }

    /// The part of a voxel plane that reaches rays of one lattice phase [values].
    size_t values(int w)
    {
        const Plane& p = plane(w);
        if (!p.any()) return 0;
        const int rows = std::min(rays - 1, p.v_high - margin) - std::max(0, p.v_low - margin) + 1;
        const int columns = std::min(rays - 1, p.u_high - margin) - std::max(0, p.u_low - margin) + 1;
        return rows > 0 && columns > 0 ? size_t(rows) * size_t(columns) : 0;
    }

    /// Values of voxels that were added to rays.
    size_t products() const { return products_; }

    /// Density depth at the targets of one block that lie on plane n and belong to this tile.
    void write(int n, const Vec3i& block, float* value) const
    {
        const int k = f_.sign * n - 8 * block[f_.w];
        if (k < 0 || k > 7) return;
        const double w = n + f_.ow, cu = f_.ou - f_.mu * w, cv = f_.ov - f_.mv * w;
        const int su = ifloor(cu), sv = ifloor(cv);
        const double fu = (cu - su) * r_, fv = (cv - sv) * r_;
        const int p = std::min(int(fu), r_ - 1), q = std::min(int(fv), r_ - 1);
        const int stride[3] = {64, 8, 1};
        for (int j = 0; j < 8; ++j) {
            const int b = 8 * block[f_.v] + j + sv - b0_;
            if (b < 0 || b >= tile) continue;
            for (int i = 0; i < 8; ++i) {
                const int a = 8 * block[f_.u] + i + su - a0_;
                if (a < 0 || a >= tile) continue;
                const double x = fu - p, y = fv - q;
                value[k * stride[f_.w] + j * stride[f_.v] + i * stride[f_.u]] =
                    float((1 - y) * ((1 - x) * at(a, b, p, q) + x * at(a, b, p + 1, q)) +
                          y * ((1 - x) * at(a, b, p, q + 1) + x * at(a, b, p + 1, q + 1)));
            }
        }
    }

private:
    double* phase(int p, int q) { return depth_.data() + size_t(q * r_ + p) * rays * row; }

    /// The ray at (a + p/r, b + q/r); p and q may be r.
    double at(int a, int b, int p, int q) const
    {
        a += p / r_;
        b += q / r_;
        return depth_[(size_t(q % r_) * r_ + p % r_) * rays * row + size_t(b) * row + a];
    }

    /// The plane of voxels w, gathered when it is new. Four are kept: a step needs three.
    const Plane& plane(int w)
    {
        Plane& p = planes_[size_t(w & 3)];
        if (p.valid && p.w == w) return p;
        p.valid = true;
        p.w = w;
        p.u0 = a0_ + ifloor(f_.mu * w) - margin;
        p.v0 = b0_ + ifloor(f_.mv * w) - margin;
        p.u_low = p.v_low = span;
        p.u_high = p.v_high = -1;
        p.value.fill(0);
        const int k = f_.sign * w;
        constexpr int stride[3] = {BrickMap::sx, BrickMap::sy, 1};
        const int su = stride[f_.u];
        for (int bv = p.v0 >> 3; bv <= (p.v0 + span - 1) >> 3; ++bv)
            for (int bu = p.u0 >> 3; bu <= (p.u0 + span - 1) >> 3; ++bu) {
                Vec3i b;
                b[f_.u] = bu;
                b[f_.v] = bv;
                b[f_.w] = k >> 3;
                const float* brick = density_.find(b);
                if (!brick) continue;
                brick += (k & 7) * stride[f_.w];
                const int u_first = std::max(p.u0, bu * 8), u_last = std::min(p.u0 + span - 1, bu * 8 + 7);
                const int v_first = std::max(p.v0, bv * 8), v_last = std::min(p.v0 + span - 1, bv * 8 + 7);
                for (int v = v_first; v <= v_last; ++v) {
                    const float* from = brick + (v & 7) * stride[f_.v] + (u_first & 7) * su;
                    float* to = p.value.data() + size_t(v - p.v0) * span + (u_first - p.u0);
                    for (int u = u_first; u <= u_last; ++u, from += su) {
                        *to++ = *from;
                        if (*from != 0) p.note(v - p.v0, u - p.u0);
                    }
                }
            }
        return p;
    }

    const BrickMap& density_;
    const LatticeFrame& f_;
    int r_, a0_, b0_;
    size_t products_ = 0;
    std::vector<double> depth_;  // [phase q, p][b][a], density x world unit
    std::array<Plane, 4> planes_;
};

/// One block of density (target < 0) or of targets that a tile's rays meet, in layer n >> 3 along w.
struct Visit {
    int tu, tv, layer, target;
    bool operator<(const Visit& o) const
    {
        if (tv != o.tv) return tv < o.tv;
        if (tu != o.tu) return tu < o.tu;
        if (layer != o.layer) return layer < o.layer;
        return target < o.target;
    }
};

/// The tiles that hold rays through block b, widened by `wide` voxels.
void add_visits(const LatticeFrame& f, const Vec3i& b, int wide, int target, std::vector<Visit>& visits)
{
    const int w0 = f.sign > 0 ? 8 * b[f.w] : -(8 * b[f.w] + 7);
    const auto range = [&](int index, double slope, double offset, int& first, int& last) {
        const double lo = -slope * (w0 - wide + f.ow), hi = -slope * (w0 + 7 + wide + f.ow);
        first = floor_div(8 * index - wide + ifloor(std::min(lo, hi) + offset), tile);
        last = floor_div(8 * index + 7 + wide + ifloor(std::max(lo, hi) + offset), tile);
    };
    int u0, u1, v0, v1;
    range(b[f.u], f.mu, f.ou, u0, u1);
    range(b[f.v], f.mv, f.ov, v0, v1);
    for (int tv = v0; tv <= v1; ++tv)
        for (int tu = u0; tu <= u1; ++tu)
            for (int layer = w0 >> 3; layer <= (w0 + 7) >> 3; ++layer) visits.push_back({tu, tv, layer, target});
}

/// Blocks of 8^3 voxels with one value each at (x*8 + y)*8 + z.
struct VoxelBlocks {
    std::vector<Vec3i> block;
    std::vector<float> value;  // 512 for each block
};

/// Advances one tile through all blocks on its way; its visits are sorted by layer. Returns Tile::products().
size_t run_tile(const BrickMap& density, const LatticeFrame& frame, int rays_per_voxel, const Visit* visit,
                const Visit* end, VoxelBlocks& targets)
{
    Tile rays_of_tile(density, frame, rays_per_voxel, visit->tu * tile, visit->tv * tile);
    int done = 8 * visit->layer - 4;  // the last plane reached; nothing lies before it
    const Visit* writing = visit;     // targets are written plane by plane, from their layer's first visit on
    for (const Visit* v = visit; v < end; ++v) {
        if (v + 1 < end && (v + 1)->layer == v->layer) continue;  // the last of a layer stands for it
        // Density in a layer reaches rays two planes before it and three behind.
        const int first = std::max(done + 1, 8 * v->layer - 2), last = 8 * v->layer + 10;
        for (int n = first; n <= last; ++n) {
            rays_of_tile.step(n);
            while (writing < end && writing->layer < (n >> 3)) ++writing;
            for (const Visit* t = writing; t < end && t->layer == (n >> 3); ++t)
                if (t->target >= 0)
                    rays_of_tile.write(n, targets.block[size_t(t->target)], &targets.value[size_t(t->target) * 512]);
        }
        done = last;
    }
    return rays_of_tile.products();
}

/// The visits of a lattice, sorted and each once.
std::vector<Visit> sorted_visits(std::vector<Visit> visits)
{
    std::sort(visits.begin(), visits.end());
    visits.erase(
        std::unique(visits.begin(), visits.end(), [](const Visit& p, const Visit& q) { return !(p < q) && !(q < p); }),
        visits.end());
    return visits;
}

/// Where the visits of each tile begin, and the end of the last.
std::vector<size_t> tiles_of(const std::vector<Visit>& visits)
{
    std::vector<size_t> begin;
    for (size_t n = 0; n < visits.size(); ++n)
        if (n == 0 || visits[n].tu != visits[n - 1].tu || visits[n].tv != visits[n - 1].tv) begin.push_back(n);
    begin.push_back(visits.size());
    return begin;
}

/// Depths at voxel centre + the offset of a frame. Counts products where `products` is not null.
void fill_along(const BrickMap& density, const LatticeFrame& frame, int rays_per_voxel, VoxelBlocks& targets,
                const Progress& progress, std::atomic<size_t>* products)
{
    targets.value.assign(targets.block.size() * 512, 0.0f);
    std::vector<Visit> visits;
    for (const auto& b : density.bricks()) add_visits(frame, b, 2, -1, visits);
    for (size_t n = 0; n < targets.block.size(); ++n) add_visits(frame, targets.block[n], 0, int(n), visits);
    visits = sorted_visits(std::move(visits));
    const std::vector<size_t> begin = tiles_of(visits);
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), begin.size() - 1, [&](size_t n) {
        const size_t added =
            run_tile(density, frame, rays_per_voxel, &visits[begin[n]], visits.data() + begin[n + 1], targets);
        if (products) *products += added;
        report(progress, double(++done) / double(begin.size() - 1));
    });
}

/// As above, and the mean over the frames of a tie.
void fill(const BrickMap& density, const Vec3d& to_light, int rays_per_voxel, const Vec3d& offset, VoxelBlocks& targets,
          const Progress& progress, std::atomic<size_t>* products)
{
    targets.value.assign(targets.block.size() * 512, 0.0f);
    if (density.empty() || targets.block.empty()) return;
    const std::vector<LatticeFrame> frames = frames_of(density, to_light, offset);
    if (frames.size() == 1) return fill_along(density, frames[0], rays_per_voxel, targets, progress, products);
    std::vector<double> sum(targets.value.size(), 0.0);
    for (size_t n = 0; n < frames.size(); ++n) {
        const Progress part =
            progress ? Progress([&](double f) { return progress((double(n) + f) / double(frames.size())); })
                     : Progress();
        fill_along(density, frames[n], rays_per_voxel, targets, part, products);
        for (size_t k = 0; k < sum.size(); ++k) sum[k] += double(targets.value[k]);
    }
    for (size_t k = 0; k < sum.size(); ++k) targets.value[k] = float(sum[k] / double(frames.size()));
}

/// Refined targets are found for one offset within a voxel at a time: each such set is a lattice of whole voxels.
std::vector<float> refined_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& blocks,
                                  int rays_per_voxel, int m, const Progress& progress, std::atomic<size_t>* products)
{
    VoxelBlocks voxels;                          // those that the targets lie in
    std::map<std::array<int, 3>, size_t> place;  // of a block among them
    for (const Vec3i& b : blocks)
        for (int n = 0; n < 8; ++n) {
            const auto block = [&](int a) { return floor_div(b[a] * 8 + ((n >> a) & 1) * 7, m) >> 3; };
            const std::array<int, 3> at{block(0), block(1), block(2)};
            if (place.emplace(at, voxels.block.size()).second) voxels.block.push_back({at[0], at[1], at[2]});
        }
    std::vector<float> depth(blocks.size() * 512);
    const int offsets = m * m * m;
    for (int n = 0; n < offsets; ++n) {
        const int offset[3] = {n / (m * m), n / m % m, n % m};
        const Progress part = progress ? Progress([&](double f) { return progress((n + f) / offsets); }) : Progress();
        fill(density, to_light, rays_per_voxel, Vec3d(offset[0], offset[1], offset[2]) / m, voxels, part, products);
        tbb::parallel_for(size_t(0), blocks.size(), [&](size_t b) {
            for (int k = 0; k < 512; ++k) {
                const int within[3] = {k >> 6, (k >> 3) & 7, k & 7};
                int voxel[3];
                bool here = true;
                for (int a = 0; a < 3; ++a) {
                    const int target = blocks[b][a] * 8 + within[a];
                    voxel[a] = floor_div(target, m);
                    here = here && target - voxel[a] * m == offset[a];
                }
                if (!here) continue;
                const size_t from = place.at({voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3}) * 512;
                depth[b * 512 + size_t(k)] =
                    voxels.value[from + size_t((voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7))];
            }
        });
    }
    return depth;
}

}  // namespace

std::vector<float> lattice_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& blocks,
                                  const LatticeOptions& options, const Progress& progress)
{
    if (options.refine > 1)
        return refined_depths(density, to_light, blocks, options.rays_per_voxel, options.refine, progress,
                              options.products);
    VoxelBlocks targets{blocks, {}};
    fill(density, to_light, options.rays_per_voxel, options.offset, targets, progress, options.products);
    return std::move(targets.value);
}

double lattice_taps(const BrickMap& density, const Vec3d& to_light, const LatticeOptions& options)
{
    double taps = 0;
    for (const LatticeFrame& frame : frames_of(density, to_light, options.offset))
        taps += mean_taps(frame, options.rays_per_voxel);
    return taps;
}

size_t lattice_products(const BrickMap& density, const Vec3d& to_light, const LatticeOptions& options)
{
    if (density.empty()) return 0;
    const LatticeFrame frame = frames_of(density, to_light, options.offset).front();
    std::vector<Visit> visits;
    for (const auto& b : density.bricks()) add_visits(frame, b, 2, -1, visits);
    visits = sorted_visits(std::move(visits));
    const std::vector<size_t> begin = tiles_of(visits);
    std::atomic<size_t> values{0};
    tbb::parallel_for(size_t(0), begin.size() - 1, [&](size_t n) {
        const Visit& first = visits[begin[n]];
        Tile rays_of_tile(density, frame, 1, first.tu * tile, first.tv * tile);
        int done = 8 * first.layer - 4;
        for (size_t v = begin[n]; v < begin[n + 1]; ++v)
            for (int w = std::max(done + 1, 8 * visits[v].layer); w <= 8 * visits[v].layer + 7; ++w) {
                values += rays_of_tile.values(w);
                done = w;
            }
    });
    const double phases = double(options.rays_per_voxel) * options.rays_per_voxel;
    const double offsets = double(options.refine) * options.refine * options.refine;
    double taps = 0;  // the mean over the offsets of refined targets
    for (int n = 0; n < int(offsets); ++n) {
        const int m = options.refine;
        LatticeOptions of_offset = options;
        if (m > 1) of_offset.offset = Vec3d(n / (m * m), n / m % m, n % m) / m;
        taps += lattice_taps(density, to_light, of_offset) / offsets;
    }
    return size_t(double(values) * phases * offsets * taps);
}

}  // namespace vdbcloud
