#include "vdbcloud/sweep/transport_sweep.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sweep/aprons.h"
#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/sweep/face_tallies.h"
#include "vdbcloud/sweep/patch_light.h"
#include "vdbcloud/sweep/periodic_sweep.h"
#include "vdbcloud/sweep/plane_tallies.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace vdbcloud {

namespace {

using block_sweep::batch;
using block_sweep::group;
using block_sweep::Layout;
using block_sweep::Rows;
using block_sweep::Scratch;
using Sign = std::array<int, 3>;

constexpr int most_terms = 64 + 192;  // degree 7, and suns

Sign signs(int octant) { return {octant & 4 ? -1 : 1, octant & 2 ? -1 : 1, octant & 1 ? -1 : 1}; }

/// All octants; over a ground those first whose light it reflects.
std::array<int, 8> octants(const PatchLight* ground)
{
    std::array<int, 8> all{0, 1, 2, 3, 4, 5, 6, 7};
    if (ground)
        std::stable_partition(all.begin(), all.end(), [&](int octant) { return ground->leaves(signs(octant)); });
    return all;
}

/// Blocks in upstream order for one octant of directions. Tiles of blocks of one level do not depend on one another;
/// blocks of a tile are in order.
struct Order {
    std::vector<int32_t> block;
    std::vector<size_t> tile;   ///< begin of each tile in `block`, and the end
    std::vector<size_t> level;  ///< begin of each level in `tile`, and the end
};

/// Tiles of 2^bits blocks along each axis.
Order order_of(const Blocks& blocks, const Sign& sign, const std::array<int, 3>& bits)
{
    struct Keyed {
        int64_t level;
        std::array<int, 3> tile, at;
        int32_t block;
        bool operator<(const Keyed& o) const { return std::tie(level, tile, at) < std::tie(o.level, o.tile, o.at); }
    };
    std::vector<Keyed> keyed(blocks.count());
    for (size_t b = 0; b < blocks.count(); ++b) {
        Keyed& key = keyed[b];
        key.level = 0;
        key.block = int32_t(b);
        for (size_t a = 0; a < 3; ++a) {
            key.at[a] = sign[a] * blocks.at(b)[int(a)];
            key.tile[a] = sign[a] * (blocks.at(b)[int(a)] >> bits[a]);
            key.level += key.tile[a];
        }
    }
    std::sort(keyed.begin(), keyed.end());
    Order order;
    for (size_t n = 0; n < keyed.size(); ++n) {
        const bool next = n == 0 || keyed[n].level != keyed[n - 1].level;
        if (next) order.level.push_back(order.tile.size());
        if (next || keyed[n].tile != keyed[n - 1].tile) order.tile.push_back(n);
        order.block.push_back(keyed[n].block);
    }
    order.level.push_back(order.tile.size());
    order.tile.push_back(keyed.size());
    return order;
}

/// Large tiles keep a block's upstream faces in the cache. Tiles shrink where levels would have too few for threads.
Order order_of(const Blocks& blocks, const Sign& sign)
{
    constexpr size_t enough = 8;  // tiles a level
    for (const auto& bits : {std::array<int, 3>{2, 2, 2}, {1, 1, 2}, {0, 0, 1}}) {
        Order order = order_of(blocks, sign, bits);
        if (order.tile.size() > enough * order.level.size()) return order;
    }
    return order_of(blocks, sign, {0, 0, 0});
}

/// Directions of one octant that go through the blocks together, those of one layout before those of the other.
struct Batch {
    std::vector<SweepPath> paths;  ///< 1 to `batch`
    std::vector<float> basis;      ///< of the source: term by term, `batch` each, 0 where there is no direction
    std::vector<float> weight;     ///< of the moments, times the direction's weight: laid out as basis
};

std::vector<Batch> batches_of(const std::vector<Vec3d>& directions, const Vec3d& spacing, const Sign& sign)
{
    std::vector<Batch> batches;
    for (const Layout* layout : {&block_sweep::natural, &block_sweep::turned})
        for (size_t m = 0; m < directions.size(); ++m) {
            Vec3d step;
            bool in_octant = true;
            for (int a = 0; a < 3; ++a) {
                step[a] = directions[m][a] / spacing[a];
                in_octant = in_octant && (step[a] < 0) == (sign[size_t(a)] < 0);
            }
            if (!in_octant || block_sweep::Traversal(step).layout != layout) continue;
            if (batches.empty() || batches.back().paths.size() == batch) batches.emplace_back();
            batches.back().paths.emplace_back(step, m);
        }
    return batches;
}

}  // namespace

struct TransportSweep::Impl {
    Impl(const VoxelIndex& of, const std::vector<SweepFace>& faces)
        : index(of), blocks(of.blocks()), aprons(blocks), tallies(blocks.count(), faces)
    {
        for (int octant = 0; octant < 8; ++octant) order[octant] = order_of(blocks, signs(octant));
    }

    void start(const SweepSet&, const SweepFields&, SweepResult& result);
    void take_basis(Batch&) const;
    void sweep_block(const Batch&, bool first, const Sign&, size_t block, SweepResult& result);
    void clear_inactive(SweepResult& result) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    Aprons aprons;
    FaceTallies tallies;
    Order order[8];
    std::vector<Vec3d> known;  // directions that the batches are of
    std::vector<Batch> batches[8];
    // Of the run:
    const SweepSet* set = nullptr;
    const SweepFields* fields = nullptr;
    std::unique_ptr<PlaneTallies> planes;  // null: not asked for
    std::unique_ptr<PatchLight> ground;    // null: none
};

void TransportSweep::Impl::start(const SweepSet& with, const SweepFields& of, SweepResult& result)
{
    set = &with;
    fields = &of;
    if (known != with.direction) {
        known = with.direction;
        tbb::parallel_for(0, 8,
                          [&](int octant) { batches[octant] = batches_of(known, index.spacing(), signs(octant)); });
        size_t width = group;
        for (const auto& of_octant : batches)
            if (!of_octant.empty() && of_octant[0].paths.size() > group) width = batch;
        aprons.clear_cache(with.count(), int(width));
    }
    result.moments.resize(size_t(with.moment_terms));
    for (auto& moment : result.moments) {
        moment.resize(blocks.slots());
        std::fill(with.count() ? moment.end() - 512 : moment.begin(), moment.end(),
                  0.0f);  // the first batch writes the other blocks
    }
    tallies.clear();
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

void TransportSweep::Impl::sweep_block(const Batch& with, bool first, const Sign& sign, size_t block,
                                       SweepResult& result)
{
    Scratch s;
    const Aprons::Upstream upstream = aprons.upstream(sign, block);
    const Rows rows(blocks.mask(block));
    const float* source[most_terms];
    float* moments[most_terms];
    for (int k = 0; k < set->source_terms; ++k) source[k] = (*fields->source)[size_t(k)].data() + block * 512;
    for (int k = 0; k < set->moment_terms; ++k) moments[k] = result.moments[size_t(k)].data() + block * 512;
    if (set->moment_terms <= 16 && !first)
        block_sweep::fetch(rows, set->moment_terms, moments);  // they are needed last
    const int n_paths = int(with.paths.size());
    block_sweep::expand(rows, n_paths, set->source_terms, source, with.basis.data(), s);
    const block_sweep::Traversal* last = nullptr;
    for (size_t d = 0; d < with.paths.size(); ++d) {
        const SweepPath& path = with.paths[d];
        const int n = int(d);
        if (!last || last->layout != path.traversal.layout)
            aprons.load_sigma(path.traversal, fields->sigma_t->data(), block, upstream, s.sigma);
        if (!last || last->axis != path.traversal.axis) block_sweep::find_lit(path.traversal, s);
        last = &path.traversal;
        block_sweep::prepare(path.traversal, n, s);
        aprons.load(path, n, block, upstream, set->inflow.empty() ? 0.0f : set->inflow[path.number], s);
        block_sweep::sweep_planes(path.traversal, n, fields->emission, s);
        aprons.store_faces(path, n, block, s);
        tallies.add(path.traversal, n, block, set->direction[path.number], set->weight[path.number], s);
        if (ground && ground->leaves(sign)) ground->add(path, n, block, s);
        if (planes) planes->add(path.traversal, n, block, set->direction[path.number], set->weight[path.number], s);
    }
    for (int d = n_paths; d % group != 0; ++d) std::fill_n(s.out[d], 512, 0.0f);
    block_sweep::accumulate(rows, n_paths, set->moment_terms, first, moments, with.weight.data(), s);
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

void TransportSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result, PlaneLight* planes,
                         SweepGround* ground)
{
    if (set.source_terms < 1 || set.source_terms > most_terms || set.moment_terms < 0 || set.moment_terms > most_terms)
        throw InputError("a sweep of " + std::to_string(set.source_terms) + " source and " +
                         std::to_string(set.moment_terms) + " moment terms: expected 1 to " +
                         std::to_string(most_terms));
    if (ground && ground->patch.has_value() == bool(periodic_))
        throw InputError(periodic_
                             ? "a patch of ground under a medium that repeats: expected a ground without a patch"
                             : "a ground without a patch under a medium that ends on all sides: expected a patch");
    if (periodic_) return periodic_->run(set, fields, result, planes, ground);
    Impl& my = *impl_;
    my.start(set, fields, result);
    my.planes = planes ? std::make_unique<PlaneTallies>(my.blocks, set, my.index.spacing(), *planes) : nullptr;
    my.ground = ground ? std::make_unique<PatchLight>(my.blocks, set, *ground) : nullptr;
    const bool lit = my.ground && !my.ground->black();
    bool first = true, reflected = false;
    for (const int octant : octants(lit ? my.ground.get() : nullptr)) {
        if (my.batches[octant].empty()) continue;
        const Sign sign = signs(octant);
        const Order& order = my.order[octant];
        const bool begins = lit && !my.ground->leaves(sign);
        if (begins && !reflected) {
            my.ground->reflect();
            reflected = true;
        }
        const PatchLight* below = begins ? my.ground.get() : nullptr;
        my.aprons.start(sign, below);
        for (Batch& each : my.batches[octant]) {
            my.take_basis(each);
            for (size_t level = 0; level + 1 < order.level.size(); ++level)
                tbb::parallel_for(order.level[level], order.level[level + 1], [&](size_t tile) {
                    for (size_t n = order.tile[tile]; n < order.tile[tile + 1]; ++n)
                        my.sweep_block(each, first, sign, size_t(order.block[n]), result);
                });
            if (my.planes) my.planes->add_voids(each.paths, my.aprons, below);
            if (my.ground && my.ground->leaves(sign)) my.ground->add_voids(each.paths, my.aprons);
            first = false;
        }
    }
    if (my.ground && !reflected) my.ground->reflect();
    my.clear_inactive(result);
    my.tallies.write(result.tally);
    if (my.planes) my.planes->write();
    if (my.planes && my.ground) my.ground->write(my.index.spacing(), *planes);
}

size_t TransportSweep::bytes() const
{
    if (periodic_) return periodic_->bytes();
    size_t total = impl_->aprons.bytes() + impl_->tallies.bytes();
    for (int octant = 0; octant < 8; ++octant) {
        const Order& order = impl_->order[octant];
        total += order.block.size() * sizeof(int32_t) + (order.tile.size() + order.level.size()) * sizeof(size_t);
        for (const Batch& each : impl_->batches[octant])
            for (const SweepPath& path : each.paths) total += path.bytes();
    }
    return total;
}

}  // namespace vdbcloud
