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
using block_sweep::Rows;
using block_sweep::Scratch;
using Sign = std::array<int, 3>;

constexpr int most_terms = 64 + 192;  // degree 7, and suns

Sign signs(int octant) { return {octant & 4 ? -1 : 1, octant & 2 ? -1 : 1, octant & 1 ? -1 : 1}; }

/// Octants whose directions go through the blocks together: two that differ along one axis, or one.
using Pass = std::vector<int>;

int bit_of(int axis) { return 4 >> axis; }

/// All octants; over a ground those first whose light it reflects.
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

/// Blocks in upstream order for the octants of a pass. Columns of blocks run along one axis, upstream or downstream;
/// columns of a tile are in order, and tiles of one level do not depend on one another.
struct Order {
    std::vector<int32_t> block;
    std::vector<size_t> column;  ///< begin of each column in `block`, and the end
    std::vector<size_t> tile;    ///< begin of each tile in `column`, and the end
    std::vector<size_t> level;   ///< begin of each level in `tile`, and the end

    bool enough() const { return tile.size() > 6 * level.size(); }  ///< for threads
    size_t bytes() const
    {
        return block.size() * sizeof(int32_t) + (column.size() + tile.size() + level.size()) * sizeof(size_t);
    }
};

/// Tiles of 2^bits x 2^bits columns along `axis`; signs across it.
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
    return order;
}

/// Large tiles keep a block's upstream faces in the cache. They shrink, and columns run along another axis, where
/// levels would have too few tiles for threads.
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
          tallies(blocks.count(), faces)
    {
        const auto [along, bits] = axis_and_bits(blocks);
        axis = along;
        for (int octant = 0; octant < 8; ++octant)
            if (!(octant & bit_of(axis))) order[octant] = order_of(blocks, signs(octant), axis, bits);
    }

    void start(const SweepSet&, const SweepFields&, SweepResult& result);
    void take_basis(Batch&) const;
    void sweep_block(const Batch&, bool first, int octant, int of_pass, size_t block, SweepResult& result);
    void sweep_batches(const Pass& pass, const std::vector<Batch*>& each, bool first, SweepResult& result);
    void clear_inactive(SweepResult& result) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    VoidRays rays;
    std::array<Aprons, 2> aprons;  // by octant of a pass
    FaceTallies tallies;
    int axis;                  // of the columns
    Order order[8];            // by the first octant of a pass
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
        for (Aprons& each : aprons) each.clear_cache(with.count(), int(width));
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

void TransportSweep::Impl::sweep_block(const Batch& with, bool first, int octant, int of_pass, size_t block,
                                       SweepResult& result)
{
    Scratch s;
    const Sign sign = signs(octant);
    Aprons& passing = aprons[size_t(of_pass)];
    const Aprons::Upstream upstream = passing.upstream(sign, block);
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
            block_sweep::take_sigma(*path.traversal.layout, fields->sigma_t->data() + block * 512, s);
        if (!last || last->axis != path.traversal.axis) {
            passing.load_sigma(path.traversal, fields->sigma_t->data(), upstream, s);
            block_sweep::find_lit(path.traversal, blocks.mask(block), s);
        }
        last = &path.traversal;
        block_sweep::prepare(path.traversal, n, s);
        passing.load(path, n, block, upstream, set->inflow.empty() ? 0.0f : set->inflow[path.number], s);
        block_sweep::sweep_planes(path.traversal, n, fields->emission, s, passing.faces(block, n));
        passing.leave(path, n, block, s);
        if (tallies.any(block) || planes) block_sweep::pad(path.traversal, s);
        tallies.add(path.traversal, n, block, set->direction[path.number], set->weight[path.number], s);
        if (ground && ground->leaves(sign)) ground->add(path, n, block, s);
        if (planes)
            planes->add(path.traversal, of_pass, n, block, set->direction[path.number], set->weight[path.number], s);
    }
    for (int d = n_paths; d % group != 0; ++d) std::fill_n(s.out[d], 512, 0.0f);
    block_sweep::accumulate(rows, n_paths, set->moment_terms, first, moments, with.weight.data(), s);
}

/// Takes a batch of each octant through a column before the next column, so that its moments stay in the cache.
void TransportSweep::Impl::sweep_batches(const Pass& pass, const std::vector<Batch*>& each, bool first,
                                         SweepResult& result)
{
    const Order& of = order[pass[0] & ~bit_of(axis)];
    const auto sweep_column = [&](size_t column) {
        bool begin = first;
        for (size_t n = 0; n < pass.size(); ++n) {
            if (!each[n]) continue;
            const size_t from = of.column[column], end = of.column[column + 1];
            const bool upwards = signs(pass[n])[size_t(axis)] > 0;
            for (size_t k = from; k < end; ++k)
                sweep_block(*each[n], begin, pass[n], int(n), size_t(of.block[upwards ? k : from + end - 1 - k]),
                            result);
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
    for (const Pass& pass : passes(my.axis, lit ? my.ground.get() : nullptr)) {
        const bool begins = lit && !my.ground->leaves(signs(pass[0]));
        if (begins && !reflected) {
            my.ground->reflect();
            reflected = true;
        }
        const PatchLight* below = begins ? my.ground.get() : nullptr;
        size_t count = 0;
        for (size_t n = 0; n < pass.size(); ++n) {
            my.aprons[n].start(signs(pass[n]), below);
            count = std::max(count, my.batches[pass[n]].size());
        }
        for (size_t k = 0; k < count; ++k) {
            std::vector<Batch*> each(pass.size(), nullptr);
            for (size_t n = 0; n < pass.size(); ++n)
                if (k < my.batches[pass[n]].size()) my.take_basis(*(each[n] = &my.batches[pass[n]][k]));
            my.sweep_batches(pass, each, first, result);
            first = false;
            for (size_t n = 0; n < pass.size(); ++n) {
                if (!each[n]) continue;
                if (my.planes) my.planes->add_voids(each[n]->paths, int(n), my.aprons[n], below);
                if (my.ground && my.ground->leaves(signs(pass[n]))) my.ground->add_voids(each[n]->paths, my.aprons[n]);
            }
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
    size_t total = impl_->rays.bytes() + impl_->tallies.bytes();
    for (const Aprons& each : impl_->aprons) total += each.bytes();
    for (int octant = 0; octant < 8; ++octant) {
        total += impl_->order[octant].bytes();
        for (const Batch& each : impl_->batches[octant])
            for (const SweepPath& path : each.paths) total += path.bytes();
    }
    return total;
}

}  // namespace vdbcloud
