#include "vdbcloud/sweep/transport_sweep.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sweep/aprons.h"
#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/sweep/face_tallies.h"
#include "vdbcloud/sweep/patch_light.h"
#include "vdbcloud/sweep/periodic_sweep.h"
#include "vdbcloud/sweep/plane_tallies.h"
#include "vdbcloud/sweep/sweep_order.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

using block_sweep::batch;
using block_sweep::group;
using block_sweep::Rows;
using block_sweep::Scratch;
using sweep_order::bit_of;
using sweep_order::Order;
using sweep_order::Pass;
using sweep_order::Sign;
using sweep_order::signs;

constexpr int most_terms = 64 + 192;  // degree 7, and suns

/// Directions of one octant that go through the blocks together, those that cross planes of one axis after one another.
struct Batch {
    std::vector<SweepPath> paths;  ///< 1 to `batch`
    std::vector<float> basis;      ///< of the source: term by term, `batch` each, 0 where there is no direction
    std::vector<float> weight;     ///< of the moments, times the direction's weight: laid out as basis
};

std::vector<Batch> batches_of(const std::vector<Vec3d>& directions, const Vec3d& spacing, const Sign& sign)
{
    std::vector<Batch> batches;
    for (int across = 0; across < 3; ++across)
        for (size_t m = 0; m < directions.size(); ++m) {
            Vec3d step;
            bool in_octant = true;
            for (int a = 0; a < 3; ++a) {
                step[a] = directions[m][a] / spacing[a];
                in_octant = in_octant && (step[a] < 0) == (sign[size_t(a)] < 0);
            }
            if (!in_octant || block_sweep::Traversal(step).axis[0] != across) continue;
            if (batches.empty() || batches.back().paths.size() == batch) batches.emplace_back();
            batches.back().paths.emplace_back(step, m);
        }
    return batches;
}

}  // namespace

struct TransportSweep::Impl {
    Impl(const VoxelIndex& of, const std::vector<SweepFace>& faces)
        : index(of), blocks(of.blocks()), rays(blocks), aprons{Aprons(blocks, rays), Aprons(blocks, rays)},
          tallies(1, FaceTallies(blocks.count(), faces))
    {
        const auto [along, bits] = sweep_order::axis_and_bits(blocks);
        axis = along;
        for (int octant = 0; octant < 8; ++octant)
            if (!(octant & bit_of(axis))) {
                order[octant] = sweep_order::order_of(blocks, signs(octant), axis, bits);
                places = std::max(places, order[octant].places);
            }
    }

    void run(const std::vector<float>& sigma_t, bool emission, const std::vector<SweepChannel>&);
    void start();
    void take_basis(Batch&) const;
    void take_walls(const SweepPath&, size_t block, Scratch* s) const;
    void sweep_block(const Batch&, bool first, int octant, int of_pass, size_t block);
    void sweep_batches(const Pass& pass, const std::vector<Batch*>& each, bool first);
    void clear_inactive(SweepResult& result) const;
    std::vector<std::vector<PlaneTallies*>> planes_alike() const;
    size_t bytes() const;

    const VoxelIndex& index;
    const Blocks& blocks;
    VoidRays rays;
    std::array<Aprons, 2> aprons;      // by octant of a pass
    std::vector<FaceTallies> tallies;  // by channel
    int axis;                          // of the columns
    Order order[8];                    // by the first octant of a pass
    size_t places = 0;                 // of the order that has most
    std::vector<Vec3d> known;          // directions that the batches are of
    std::vector<Batch> batches[8];
    // Of the run:
    const SweepSet* set = nullptr;
    const std::vector<float>* sigma_t = nullptr;
    bool emission = false;
    std::vector<SweepChannel> channels;
    std::vector<std::unique_ptr<PlaneTallies>> planes;  // by channel; null: not asked for
    std::vector<std::unique_ptr<PatchLight>> grounds;   // by channel; empty: none
    std::vector<WallSums> walls;                        // the same
    size_t held = 0;                                    // bytes() of the last run
};

void TransportSweep::Impl::start()
{
    if (known != set->direction) {
        known = set->direction;
        tbb::parallel_for(0, 8,
                          [&](int octant) { batches[octant] = batches_of(known, index.spacing(), signs(octant)); });
        size_t width = group;
        for (const auto& of_octant : batches)
            if (!of_octant.empty() && of_octant[0].paths.size() > group) width = batch;
        for (Aprons& each : aprons) each.clear_cache(set->count(), int(width));
    }
    for (Aprons& each : aprons) each.set_channels(int(channels.size()), places);
    tallies.resize(channels.size(), tallies[0]);
    planes.clear();
    grounds.clear();
    walls.clear();
    for (size_t c = 0; c < channels.size(); ++c) {
        const SweepChannel& channel = channels[c];
        channel.result->moments.resize(size_t(set->moment_terms));
        for (auto& moment : channel.result->moments) {
            moment.resize(blocks.slots());
            std::fill(set->count() ? moment.end() - 512 : moment.begin(), moment.end(),
                      0.0f);  // the first batch writes the other blocks
        }
        tallies[c].clear();
        planes.push_back(channel.planes ? std::make_unique<PlaneTallies>(blocks, *channel.set, index.spacing(), int(c),
                                                                         *channel.planes)
                                        : nullptr);
        if (channel.ground) grounds.push_back(std::make_unique<PatchLight>(blocks, *channel.set, *channel.ground));
        if (channel.walls) walls.emplace_back(*channel.walls);
    }
}

/// The radiance of the block's opaque voxels along a direction.
void TransportSweep::Impl::take_walls(const SweepPath& path, size_t block, Scratch* s) const
{
    for (size_t c = 0; c < walls.size(); ++c) {
        const WallLight& light = walls[c].light();
        const SweepWalls& of = *light.walls;
        s[c].wall = nullptr;
        if (of.voxels_of[block] == of.voxels_of[block + 1]) continue;
        block_sweep::clear_walls(s[c]);
        for (uint32_t n = of.voxels_of[block]; n < of.voxels_of[block + 1]; ++n)
            block_sweep::set_wall(*path.traversal.layout, of.voxels[n].slot % Blocks::size,
                                  light.along(of.voxels[n], set->direction[path.number]), s[c]);
    }
}

void TransportSweep::Impl::take_basis(Batch& to) const
{
    const size_t sources = size_t(set->source_terms), moments = size_t(set->moment_terms);
    to.basis.assign(sources * batch, 0.0f);
    to.weight.assign(moments * batch, 0.0f);
    for (size_t d = 0; d < to.paths.size(); ++d) {
        const size_t m = to.paths[d].number;
        for (size_t k = 0; k < sources; ++k) to.basis[k * batch + d] = set->source_basis[m * sources + k];
        for (size_t k = 0; k < moments; ++k)
            to.weight[k * batch + d] = set->weight[m] * set->moment_basis[m * moments + k];
    }
}

void TransportSweep::Impl::sweep_block(const Batch& with, bool first, int octant, int of_pass, size_t block)
{
    Scratch all[block_sweep::most_channels];
    Scratch& s = all[0];
    const Sign sign = signs(octant);
    Aprons& passing = aprons[size_t(of_pass)];
    const Aprons::Upstream upstream = passing.upstream(sign, block);
    const Rows rows(blocks.mask(block));
    const size_t count = channels.size();
    const int n_paths = int(with.paths.size());
    float* moments[block_sweep::most_channels][most_terms];
    bool padded[block_sweep::most_channels];
    for (size_t c = 0; c < count; ++c) {
        const float* source[most_terms];
        for (int k = 0; k < set->source_terms; ++k) source[k] = (*channels[c].source)[size_t(k)].data() + block * 512;
        for (int k = 0; k < set->moment_terms; ++k)
            moments[c][k] = channels[c].result->moments[size_t(k)].data() + block * 512;
        block_sweep::expand(rows, n_paths, set->source_terms, source, with.basis.data(), all[c]);
        padded[c] = tallies[c].any(block) || planes[c];
    }
    const block_sweep::Traversal* last = nullptr;
    for (size_t d = 0; d < with.paths.size(); ++d) {
        const SweepPath& path = with.paths[d];
        const int n = int(d);
        if (!last || last->layout != path.traversal.layout)
            block_sweep::take_sigma(*path.traversal.layout, sigma_t->data() + block * 512, s);
        if (!last || last->axis != path.traversal.axis) {
            passing.load_sigma(path.traversal, sigma_t->data(), upstream, s);
            block_sweep::find_lit(path.traversal, blocks.mask(block), s);
            for (size_t c = 1; c < count; ++c) block_sweep::share_medium(s, all[c]);
        }
        last = &path.traversal;
        float inflow[block_sweep::most_channels];
        for (size_t c = 0; c < count; ++c) {
            if (set->moment_terms <= 16 && !first)  // they are needed last, and the cache takes a few lines at once
                block_sweep::fetch(rows, set->moment_terms * n / n_paths, set->moment_terms * (n + 1) / n_paths,
                                   moments[c]);
            block_sweep::prepare(path.traversal, n, all[c]);
            inflow[c] = channels[c].set->inflow.empty() ? 0.0f : channels[c].set->inflow[path.number];
        }
        passing.load(path, n, block, upstream, inflow, all);
        if (!walls.empty()) take_walls(path, block, all);
        block_sweep::sweep_planes(path.traversal, n, emission, int(count), all, passing.faces(block, n));
        passing.leave(path, n, block, all);
        const Vec3d& direction = set->direction[path.number];
        const float weight = set->weight[path.number];
        for (size_t c = 0; c < count; ++c) {
            if (padded[c]) block_sweep::pad(path.traversal, all[c]);
            tallies[c].add(path.traversal, n, block, direction, weight, all[c]);
            if (!grounds.empty() && grounds[c]->leaves(sign)) grounds[c]->add(path, n, block, all[c]);
            if (planes[c]) planes[c]->add(path.traversal, of_pass, n, block, direction, weight, all[c]);
            if (!walls.empty())
                walls[c].add(block, direction, double(weight),
                             [&](size_t slot) { return double(all[c].out[d][slot]); });
        }
    }
    for (size_t c = 0; c < count; ++c) {
        for (int d = n_paths; d % group != 0; ++d) std::fill_n(all[c].out[d], 512, 0.0f);
        block_sweep::accumulate(rows, n_paths, set->moment_terms, first, moments[c], with.weight.data(), all[c]);
    }
}

/// Takes a batch of each octant through a column before the next column, so that its moments stay in the cache.
void TransportSweep::Impl::sweep_batches(const Pass& pass, const std::vector<Batch*>& each, bool first)
{
    const Order& of = order[pass[0] & ~bit_of(axis)];
    const auto sweep_column = [&](size_t column) {
        bool begin = first;
        for (size_t n = 0; n < pass.size(); ++n) {
            if (!each[n]) continue;
            const size_t from = of.column[column], end = of.column[column + 1];
            const bool upwards = signs(pass[n])[size_t(axis)] > 0;
            for (size_t k = from; k < end; ++k)
                sweep_block(*each[n], begin, pass[n], int(n), size_t(of.block[upwards ? k : from + end - 1 - k]));
            begin = false;
        }
    };
    for (size_t level = 0; level + 1 < of.level.size(); ++level)
        tbb::parallel_for(of.level[level], of.level[level + 1], [&](size_t tile) {
            for (size_t column = of.tile[tile]; column < of.tile[tile + 1]; ++column) sweep_column(column);
        });
}

void TransportSweep::Impl::clear_inactive(SweepResult& result) const
{
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t x = 0; x < 8; ++x) {
            const uint64_t mask = blocks.mask(b)[x];
            if (!~mask) continue;
            for (auto& moment : result.moments)
                for (size_t n = 0; n < 64; ++n)
                    if (!(mask >> n & 1)) moment[b * 512 + x * 64 + n] = 0;
        }
    });
}

/// Channels whose planes are asked for, those with cells and those without.
std::vector<std::vector<PlaneTallies*>> TransportSweep::Impl::planes_alike() const
{
    std::vector<std::vector<PlaneTallies*>> alike;
    for (const bool by_cell : {false, true}) {
        std::vector<PlaneTallies*> some;
        for (const auto& each : planes)
            if (each && each->by_cell() == by_cell) some.push_back(each.get());
        if (!some.empty()) alike.push_back(some);
    }
    return alike;
}

TransportSweep::TransportSweep(const VoxelIndex& index, std::vector<SweepFace> faces)
{
    const Vec3i& period = index.blocks().period();
    if (period[0] && period[1] && period[2])
        throw InputError("a medium that repeats along all axes: expected one that light leaves");
    if (period != Vec3i(0, 0, 0))
        periodic_ = std::make_unique<PeriodicSweep>(index, faces);
    else
        impl_ = std::make_unique<Impl>(index, faces);
}
TransportSweep::~TransportSweep() = default;

void TransportSweep::Impl::run(const std::vector<float>& sigma, bool of_emission, const std::vector<SweepChannel>& of)
{
    channels = of;
    set = channels[0].set;
    sigma_t = &sigma;
    emission = of_emission;
    start();
    const PatchLight* ground = grounds.empty() ? nullptr : grounds[0].get();  // what all have in common
    const bool lit = ground && !ground->black();
    bool first = true, reflected = false;
    const auto reflect = [&] {
        if (!reflected)
            for (auto& each : grounds) each->reflect();
        reflected = true;
    };
    for (const Pass& pass : sweep_order::passes(axis, lit ? ground : nullptr)) {
        std::vector<const PatchLight*> below(channels.size(), nullptr);
        if (lit && !ground->leaves(signs(pass[0]))) {
            reflect();
            for (size_t c = 0; c < channels.size(); ++c) below[c] = grounds[c].get();
        } else {
            below.clear();
        }
        size_t count = 0;
        for (size_t n = 0; n < pass.size(); ++n) {
            aprons[n].start(signs(pass[n]), order[pass[0] & ~bit_of(axis)].place, below);
            count = std::max(count, batches[pass[n]].size());
        }
        for (size_t k = 0; k < count; ++k) {
            std::vector<Batch*> each(pass.size(), nullptr);
            for (size_t n = 0; n < pass.size(); ++n)
                if (k < batches[pass[n]].size()) take_basis(*(each[n] = &batches[pass[n]][k]));
            sweep_batches(pass, each, first);
            first = false;
            for (size_t n = 0; n < pass.size(); ++n) {
                if (!each[n]) continue;
                for (const auto& asked : planes_alike())
                    PlaneTallies::add_voids(asked, each[n]->paths, int(n), aprons[n], below);
                for (size_t c = 0; c < grounds.size() && ground->leaves(signs(pass[n])); ++c)
                    grounds[c]->add_voids(each[n]->paths, aprons[n], int(c));
            }
        }
    }
    reflect();
    for (size_t c = 0; c < channels.size(); ++c) {
        clear_inactive(*channels[c].result);
        tallies[c].write(channels[c].result->tally);
        if (planes[c]) planes[c]->write();
        if (planes[c] && ground) grounds[c]->write(index.spacing(), *channels[c].planes);
        if (!walls.empty()) walls[c].write();
    }
    held = bytes();
    for (Aprons& each : aprons) each.release();
    tallies.erase(tallies.begin() + 1, tallies.end());
    planes.clear();
    grounds.clear();
    walls.clear();
}

void TransportSweep::check(const SweepChannel& channel) const
{
    const SweepSet& set = *channel.set;
    if (set.source_terms < 1 || set.source_terms > most_terms || set.moment_terms < 0 || set.moment_terms > most_terms)
        throw InputError("a sweep of " + std::to_string(set.source_terms) + " source and " +
                         std::to_string(set.moment_terms) + " moment terms: expected 1 to " +
                         std::to_string(most_terms));
    if (channel.walls && periodic_)
        throw InputError("walls in a medium that repeats: expected one that ends on all sides");
    if (channel.ground && channel.ground->patch.has_value() == bool(periodic_))
        throw InputError(periodic_
                             ? "a patch of ground under a medium that repeats: expected a ground without a patch"
                             : "a ground without a patch under a medium that ends on all sides: expected a patch");
}

void TransportSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result, PlaneLight* planes,
                         SweepGround* ground, WallLight* walls)
{
    run(*fields.sigma_t, fields.emission, {{&set, fields.source, &result, planes, ground, walls}});
}

void TransportSweep::run(const std::vector<float>& sigma_t, bool emission, const std::vector<SweepChannel>& channels)
{
    for (const SweepChannel& channel : channels) check(channel);
    for (size_t c = 0; c < channels.size() && periodic_; ++c)
        periodic_->run(*channels[c].set, {&sigma_t, channels[c].source, emission}, *channels[c].result,
                       channels[c].planes, channels[c].ground);
    if (periodic_) return;
    constexpr size_t at_once = block_sweep::most_channels;
    for (size_t c = 0; c < channels.size(); c += at_once)
        impl_->run(sigma_t, emission,
                   {channels.begin() + std::ptrdiff_t(c),
                    channels.begin() + std::ptrdiff_t(std::min(channels.size(), c + at_once))});
}

size_t TransportSweep::Impl::bytes() const
{
    size_t total = rays.bytes() + tallies[0].bytes();
    for (const Aprons& each : aprons) total += each.bytes();
    for (int octant = 0; octant < 8; ++octant) {
        total += order[octant].bytes();
        for (const Batch& each : batches[octant])
            for (const SweepPath& path : each.paths) total += path.bytes();
    }
    return total;
}

size_t TransportSweep::bytes() const { return periodic_ ? periodic_->bytes() : impl_->held; }

}  // namespace vdbcloud
