#include "vdbcloud/sweep/light_lattice.h"

#include "vdbcloud/sweep/lattice_tile.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>

namespace vdbcloud {

namespace {

constexpr int tile = LatticeTile::tile;

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }
int ifloor(double x) { return int(std::floor(x)); }

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

/// The first plane of a block, along w.
int first_plane(const LatticeFrame& f, const Vec3i& block)
{
    return f.sign > 0 ? 8 * block[f.w] : -(8 * block[f.w] + 7);
}

/// The tiles of rays through the positions 8 * index .. + 7 along an axis, moved by `offset` and widened by `wide`
/// voxels, on planes w0 to w1.
struct TileRange {
    int first, last;
    TileRange(int index, double slope, double offset, double w0, double w1, int wide)
        : first(floor_div(8 * index - wide + ifloor(std::min(-slope * w0, -slope * w1) + offset - rounding), tile)),
          last(floor_div(8 * index + 7 + wide + ifloor(std::max(-slope * w0, -slope * w1) + offset + rounding), tile))
    {
    }
    static constexpr double rounding = 1e-6;  // a target on a ray belongs to either side
};

void add_visits(const TileRange& u, const TileRange& v, int first_plane, int last_plane, int target,
                std::vector<Visit>& visits)
{
    for (int tv = v.first; tv <= v.last; ++tv)
        for (int tu = u.first; tu <= u.last; ++tu)
            for (int layer = first_plane >> 3; layer <= last_plane >> 3; ++layer)
                visits.push_back({tu, tv, layer, target});
}

/// The tiles whose rays meet a block of density, a voxel about it included.
void add_density(const LatticeFrame& f, const Vec3i& b, std::vector<Visit>& visits)
{
    constexpr int wide = 2;
    const int w0 = first_plane(f, b);
    const auto range = [&](int index, double slope) {
        return TileRange(index, slope, 0, w0 - wide, w0 + 7 + wide, wide);
    };
    add_visits(range(b[f.u], f.mu), range(b[f.v], f.mv), w0, w0 + 7, -1, visits);
}

/// The tiles that own targets of a block.
void add_targets(const LatticeFrame& f, const LatticeOffset& offset, const Vec3i& b, int target,
                 std::vector<Visit>& visits)
{
    const int first = first_plane(f, b) + offset.shift;
    const double w = first + offset.fraction;
    add_visits(TileRange(b[f.u], f.mu, offset.u, w, w + 7, 0), TileRange(b[f.v], f.mv, offset.v, w, w + 7, 0), first,
               first + 7, target, visits);
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

/// One pass of rays along a frame.
class Pass {
public:
    Pass(const BrickMap& density, const LatticeFrame& frame, const std::vector<LatticeTargets>& sets,
         int rays_per_voxel, std::vector<std::vector<float>>& depth)
        : density_(density), frame_(frame), rays_per_voxel_(rays_per_voxel)
    {
        for (const LatticeTargets& set : sets) offset_.emplace_back(frame, set.offset);
        stops_ = stops_of(offset_);
        for (const auto& b : density.bricks()) add_density(frame, b, visits_);
        for (size_t k = 0; k < sets.size(); ++k)
            for (size_t n = 0; n < sets[k].blocks.size(); ++n) {
                add_targets(frame, offset_[k], sets[k].blocks[n], int(targets_.size()), visits_);
                targets_.push_back(
                    {int(k), int(stop_of(stops_, offset_[k])), sets[k].blocks[n], depth[k].data() + n * 512});
            }
        visits_ = sorted_visits(std::move(visits_));
    }

    void run(const Progress& progress, std::atomic<size_t>* products)
    {
        const std::vector<size_t> begin = tiles_of(visits_);
        std::atomic<size_t> done{0};
        tbb::parallel_for(size_t(0), begin.size() - 1, [&](size_t n) {
            const size_t added = run_tile(visits_.data() + begin[n], visits_.data() + begin[n + 1]);
            if (products) *products += added;
            report(progress, double(++done) / double(begin.size() - 1));
        });
    }

private:
    struct Target {
        int set, stop;
        Vec3i block;
        float* value;
    };

    /// Advances one tile through all blocks on its way; its visits are sorted by layer. Returns the tile's products.
    size_t run_tile(const Visit* visit, const Visit* end) const
    {
        LatticeTile rays(density_, frame_, stops_, rays_per_voxel_, visit->tu * tile, visit->tv * tile);
        int done = 8 * visit->layer - 4;  // the last plane reached; nothing lies before it
        const Visit* writing = visit;     // targets are written stop by stop, from their layer's first visit on
        for (const Visit* v = visit; v < end; ++v) {
            if (v + 1 < end && (v + 1)->layer == v->layer) continue;  // the last of a layer stands for it
            // Density in a layer reaches rays two planes before it and three behind.
            const int first = std::max(done + 1, 8 * v->layer - 2), last = 8 * v->layer + 10;
            for (int n = first; n <= last; ++n) {
                while (writing < end && writing->layer < (n >> 3)) ++writing;
                for (int stop = 0; stop < int(stops_.size()); ++stop) {
                    rays.advance(n, size_t(stop));
                    for (const Visit* t = writing; t < end && t->layer == (n >> 3); ++t)
                        if (t->target >= 0 && targets_[size_t(t->target)].stop == stop) {
                            const Target& to = targets_[size_t(t->target)];
                            rays.write(n, offset_[size_t(to.set)], to.block, to.value);
                        }
                }
            }
            done = last;
        }
        return rays.products();
    }

    const BrickMap& density_;
    const LatticeFrame& frame_;
    int rays_per_voxel_;
    std::vector<LatticeOffset> offset_;  // of each set
    std::vector<double> stops_;
    std::vector<Target> targets_;
    std::vector<Visit> visits_;
};

/// The part of a job that step n of `count` reports.
Progress part_of(const Progress& progress, size_t n, size_t count)
{
    if (!progress) return {};
    return [&progress, n, count](double f) { return progress((double(n) + f) / double(count)); };
}

/// Refined targets lie at refine^3 offsets within a voxel: each is a set of whole voxels.
std::vector<float> refined_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& blocks,
                                  int rays_per_voxel, int m, const Progress& progress, std::atomic<size_t>* products)
{
    std::vector<Vec3i> voxels;                   // blocks that the targets lie in
    std::map<std::array<int, 3>, size_t> place;  // of a block among them
    for (const Vec3i& b : blocks)
        for (int n = 0; n < 8; ++n) {
            const auto block = [&](int a) { return floor_div(b[a] * 8 + ((n >> a) & 1) * 7, m) >> 3; };
            const std::array<int, 3> at{block(0), block(1), block(2)};
            if (place.emplace(at, voxels.size()).second) voxels.push_back({at[0], at[1], at[2]});
        }
    std::vector<LatticeTargets> sets;
    for (const Vec3d& offset : refined_offsets(m)) sets.push_back({offset, voxels});
    const auto found = lattice_depths(density, to_light, sets, rays_per_voxel, progress, products);
    std::vector<float> depth(blocks.size() * 512);
    tbb::parallel_for(size_t(0), blocks.size(), [&](size_t b) {
        for (int k = 0; k < 512; ++k) {
            const int within[3] = {k >> 6, (k >> 3) & 7, k & 7};
            int voxel[3], set = 0;
            for (int a = 0; a < 3; ++a) {
                const int target = blocks[b][a] * 8 + within[a];
                voxel[a] = floor_div(target, m);
                set = set * m + target - voxel[a] * m;
            }
            const size_t from = place.at({voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3}) * 512;
            depth[b * 512 + size_t(k)] =
                found[size_t(set)][from + size_t((voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7))];
        }
    });
    return depth;
}

}  // namespace

std::vector<std::vector<float>> lattice_depths(const BrickMap& density, const Vec3d& to_light,
                                               const std::vector<LatticeTargets>& sets, int rays_per_voxel,
                                               const Progress& progress, std::atomic<size_t>* products)
{
    const auto zero = [&] {
        std::vector<std::vector<float>> depth;
        for (const LatticeTargets& set : sets) depth.emplace_back(set.blocks.size() * 512, 0.0f);
        return depth;
    };
    std::vector<std::vector<float>> depth = zero();
    const bool none =
        std::all_of(sets.begin(), sets.end(), [](const LatticeTargets& set) { return set.blocks.empty(); });
    if (density.empty() || none) return depth;
    const std::vector<LatticeFrame> frames = frames_of(density, to_light);
    if (frames.size() == 1) {
        Pass(density, frames[0], sets, rays_per_voxel, depth).run(progress, products);
        return depth;
    }
    std::vector<std::vector<double>> sum;
    for (const auto& of_set : depth) sum.emplace_back(of_set.size(), 0.0);
    for (size_t n = 0; n < frames.size(); ++n) {
        depth = zero();
        Pass(density, frames[n], sets, rays_per_voxel, depth).run(part_of(progress, n, frames.size()), products);
        for (size_t s = 0; s < sum.size(); ++s)
            for (size_t k = 0; k < sum[s].size(); ++k) sum[s][k] += double(depth[s][k]);
    }
    for (size_t s = 0; s < sum.size(); ++s)
        for (size_t k = 0; k < sum[s].size(); ++k) depth[s][k] = float(sum[s][k] / double(frames.size()));
    return depth;
}

std::vector<float> lattice_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& blocks,
                                  const LatticeOptions& options, const Progress& progress)
{
    if (options.refine > 1)
        return refined_depths(density, to_light, blocks, options.rays_per_voxel, options.refine, progress,
                              options.products);
    return std::move(lattice_depths(density, to_light, std::vector<LatticeTargets>{{options.offset, blocks}},
                                    options.rays_per_voxel, progress, options.products)[0]);
}

size_t lattice_products(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3d>& offsets,
                        int rays_per_voxel)
{
    if (density.empty()) return 0;
    const std::vector<LatticeFrame> frames = frames_of(density, to_light);
    std::vector<Visit> visits;
    for (const auto& b : density.bricks()) add_density(frames[0], b, visits);
    visits = sorted_visits(std::move(visits));
    const std::vector<size_t> begin = tiles_of(visits);
    const std::vector<double> whole{0.0};
    std::atomic<size_t> values{0};
    tbb::parallel_for(size_t(0), begin.size() - 1, [&](size_t n) {
        const Visit& first = visits[begin[n]];
        LatticeTile rays(density, frames[0], whole, 1, first.tu * tile, first.tv * tile);
        int done = 8 * first.layer - 4;
        for (size_t v = begin[n]; v < begin[n + 1]; ++v)
            for (int w = std::max(done + 1, 8 * visits[v].layer); w <= 8 * visits[v].layer + 7; ++w) {
                values += rays.values(w);
                done = w;
            }
    });
    double taps = 0;
    for (const LatticeFrame& frame : frames) {
        std::vector<LatticeOffset> of_frame;
        for (const Vec3d& offset : offsets) of_frame.emplace_back(frame, offset);
        taps += mean_taps(frame, stops_of(of_frame), rays_per_voxel);
    }
    return size_t(double(values) * rays_per_voxel * rays_per_voxel * taps);
}

std::vector<Vec3d> refined_offsets(int m)
{
    std::vector<Vec3d> offsets;
    for (int n = 0; n < m * m * m; ++n) offsets.push_back(Vec3d(n / (m * m), n / m % m, n % m) / m);
    return offsets;
}

}  // namespace vdbcloud
