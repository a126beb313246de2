#include "vdbcloud/sweep/transport_sweep.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/sweep/void_rays.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

using block_sweep::Frame;
using block_sweep::Layout;
using block_sweep::Scratch;

constexpr int batch = 4;         // directions that are taken through a block together
constexpr int regions = 7;       // of a block's upstream apron: three faces, three edges, a corner
constexpr int most_terms = 64;   // degree 7

/// Axes along which a region of the apron lies outside the block, as bits: faces x, y, z, edges xy, xz, yz, the corner.
constexpr int region_axes[regions] = {1, 2, 4, 3, 5, 6, 7};

/// What a block shows downstream, for one direction: on the last centres before each of its three downstream faces.
struct Faces {
    float radiance[3][64], source[3][64];
};

/// Position of (x, y, z) on face `axis`: the two other coordinates in order.
int on_face(int axis, const int* c) { return axis == 0 ? c[1] * 8 + c[2] : axis == 1 ? c[0] * 8 + c[2] : c[0] * 8 + c[1]; }

/// Blocks in upstream order for one octant of directions: those of one level do not depend on one another.
struct Order {
    std::vector<int32_t> block;
    std::vector<size_t> begin;  ///< of each level, and the end
};

Order order_of(const Blocks& blocks, const std::array<int, 3>& sign)
{
    Order order;
    std::vector<std::pair<int64_t, int32_t>> keyed(blocks.count());
    for (size_t b = 0; b < blocks.count(); ++b) {
        int64_t level = 0;
        for (int a = 0; a < 3; ++a) level += int64_t(sign[a]) * blocks.at(b)[a];
        keyed[b] = {level, int32_t(b)};
    }
    std::sort(keyed.begin(), keyed.end());
    for (size_t n = 0; n < keyed.size(); ++n) {
        if (n == 0 || keyed[n].first != keyed[n - 1].first) order.begin.push_back(n);
        order.block.push_back(keyed[n].second);
    }
    order.begin.push_back(keyed.size());
    return order;
}

}  // namespace

struct TransportSweep::Impl {
    Impl(const VoxelIndex& of, std::vector<SweepFace> list) : index(of), blocks(of.blocks()), faces(std::move(list)), rays(blocks)
    {
        if (blocks.period()[0] || blocks.period()[1] || blocks.period()[2])
            throw InputError("a periodic medium: expected one that ends on all sides; reference_sweep takes periodic ones");
        first_face.assign(blocks.count() + 1, faces.size());
        for (size_t f = faces.size(); f-- > 0;) first_face[faces[f].slot / 512] = f;
        for (size_t b = blocks.count(); b-- > 0;)
            first_face[b] = std::min(first_face[b], first_face[b + 1]);
        for (int octant = 0; octant < 8; ++octant) order[octant] = order_of(blocks, signs(octant));
    }

    static std::array<int, 3> signs(int octant) { return {octant & 4 ? -1 : 1, octant & 2 ? -1 : 1, octant & 1 ? -1 : 1}; }

    /// Directions that go through the blocks together, and where they stand in the set.
    struct Batch {
        std::vector<Frame> frame;
        std::vector<Vec3d> step;
        std::vector<size_t> direction;
    };

    void start(const SweepSet& set, const SweepFields& fields, SweepResult& result);
    void number_outer(const std::array<int, 3>& sign);
    void sweep_block(const Batch&, size_t block, SweepResult& result);
    void upstream(const std::array<int, 3>& sign, size_t block, int32_t* neighbour) const;
    void load_sigma(const Frame&, size_t block, const int32_t* neighbour, float* padded) const;
    void load_apron(const Batch&, size_t d, size_t block, const int32_t* neighbour, Scratch&);
    float through_void(const Batch&, size_t d, const int* apron, size_t block, bool& sky) const;
    void show(const Batch&, size_t d, size_t block, const Scratch&);
    void tally(const Batch&, size_t d, size_t block, const Scratch&, SweepResult&) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    std::vector<SweepFace> faces;
    std::vector<size_t> first_face;  // of each block
    VoidRays rays;
    Order order[8];
    // Of the run:
    const SweepSet* set = nullptr;
    const SweepFields* fields = nullptr;
    std::vector<Faces> shown;                     // block by block, `batch` each
    std::vector<std::array<int32_t, 3>> outer_of;  // where a block's downstream face looks into the void: its number
    std::vector<float> outer;                     // radiance that leaves such faces, 64 each, `batch` each
    std::vector<uint8_t> sky;                     // regions all of whose rays end in the sky, by direction and block
    std::vector<Vec3d> sky_of;                    // directions these are known for
};

void TransportSweep::Impl::start(const SweepSet& with, const SweepFields& of, SweepResult& result)
{
    set = &with;
    fields = &of;
    if (sky_of != with.direction) {
        sky.assign(with.count() * blocks.count(), 0);
        sky_of = with.direction;
    }
    shown.resize(blocks.count() * batch);
    result.moments.resize(size_t(with.moment_terms));
    for (auto& moment : result.moments) moment.assign(blocks.slots(), 0.0f);
    result.tally.assign(faces.size(), FaceTally{});
}

void TransportSweep::Impl::number_outer(const std::array<int, 3>& sign)
{
    outer_of.resize(blocks.count());
    int32_t count = 0;
    for (size_t b = 0; b < blocks.count(); ++b)
        for (int a = 0; a < 3; ++a)
            outer_of[b][a] = size_t(blocks.neighbours(b)[2 * a + (sign[a] > 0)]) < blocks.count() ? -1 : count++;
    outer.resize(size_t(count) * 64 * batch);
}

/// The seven upstream neighbours by region; -1 where there is none.
void TransportSweep::Impl::upstream(const std::array<int, 3>& sign, size_t block, int32_t* neighbour) const
{
    for (int region = 0; region < regions; ++region) {
        Vec3i at = blocks.at(block);
        for (int a = 0; a < 3; ++a)
            if (region_axes[region] >> a & 1) at[a] -= sign[a];
        neighbour[region] = rays.find(at);
    }
}

namespace {

/// Calls f(c, e) for every voxel of a region of the upstream apron: c its coordinates, -1..8, and e those in its own block.
template<typename F>
void each_apron(int region, const std::array<int, 3>& sign, const F& f)
{
    int lo[3], hi[3];
    for (int a = 0; a < 3; ++a) {
        const bool outside = region_axes[region] >> a & 1;
        lo[a] = outside ? (sign[a] > 0 ? -1 : 8) : 0;
        hi[a] = outside ? lo[a] : 7;
    }
    int c[3], e[3];
    for (c[0] = lo[0]; c[0] <= hi[0]; ++c[0])
        for (c[1] = lo[1]; c[1] <= hi[1]; ++c[1])
            for (c[2] = lo[2]; c[2] <= hi[2]; ++c[2]) {
                for (int a = 0; a < 3; ++a) e[a] = c[a] & 7;
                f(c, e);
            }
}

}  // namespace

void TransportSweep::Impl::load_sigma(const Frame& frame, size_t block, const int32_t* neighbour, float* padded) const
{
    const Layout& layout = *frame.layout;
    const float* sigma = fields->sigma_t->data();
    block_sweep::load_inside(layout, sigma + block * 512, padded);
    for (int region = 0; region < regions; ++region) {
        const float* from = neighbour[region] < 0 ? nullptr : sigma + size_t(neighbour[region]) * 512;
        each_apron(region, frame.sign, [&](const int* c, const int* e) {
            padded[layout.at(c[0], c[1], c[2])] = from ? from[e[0] * 64 + e[1] * 8 + e[2]] : 0.0f;
        });
    }
}

/// What comes to an apron voxel of a missing block.
float TransportSweep::Impl::through_void(const Batch& with, size_t d, const int* apron, size_t block, bool& is_sky) const
{
    const Vec3i& at = blocks.at(block);
    const Vec3d& step = with.step[d];
    const auto hit = rays.trace(Vec3d(8 * at[0] + apron[0], 8 * at[1] + apron[1], 8 * at[2] + apron[2]), step);
    is_sky = hit.block < 0;
    if (is_sky) return set->inflow.empty() ? 0.0f : set->inflow[with.direction[d]];
    const int other[2] = {hit.axis == 0 ? 1 : 0, hit.axis == 2 ? 1 : 2};
    int cell[2];
    float f[2];
    for (int k = 0; k < 2; ++k) {  // light met the centres' plane half a step before
        const double place = std::clamp(hit.at[k] - 0.5 * step[other[k]] / std::abs(step[hit.axis]), 0.0, 7.0);
        cell[k] = std::min(int(place), 6);
        f[k] = float(place - cell[k]);
    }
    const float* from = &outer[(size_t(outer_of[size_t(hit.block)][hit.axis]) * batch + d) * 64 + size_t(cell[0] * 8 + cell[1])];
    return (1 - f[0]) * ((1 - f[1]) * from[0] + f[1] * from[1]) + f[0] * ((1 - f[1]) * from[8] + f[1] * from[9]);
}

void TransportSweep::Impl::load_apron(const Batch& with, size_t d, size_t block, const int32_t* neighbour, Scratch& s)
{
    const Frame& frame = with.frame[d];
    const Layout& layout = *frame.layout;
    uint8_t& known = sky[with.direction[d] * blocks.count() + block];
    const float dark = set->inflow.empty() ? 0.0f : set->inflow[with.direction[d]];
    for (int region = 0; region < regions; ++region) {
        if (neighbour[region] >= 0) {
            const Faces& from = shown[size_t(neighbour[region]) * batch + d];
            const int axis = region_axes[region] & 1 ? 0 : region_axes[region] & 2 ? 1 : 2;
            each_apron(region, frame.sign, [&](const int* c, const int* e) {
                const int to = layout.at(c[0], c[1], c[2]), k = on_face(axis, e);
                s.radiance[to] = from.radiance[axis][k];
                s.source[to] = from.source[axis][k];
            });
            continue;
        }
        const bool all_sky = known >> region & 1;
        bool none_hit = true;
        each_apron(region, frame.sign, [&](const int* c, const int*) {
            const int to = layout.at(c[0], c[1], c[2]);
            bool is_sky = true;
            s.radiance[to] = all_sky ? dark : through_void(with, d, c, block, is_sky);
            s.source[to] = 0;
            none_hit = none_hit && is_sky;
        });
        if (none_hit) known = uint8_t(known | 1 << region);
    }
}

/// Keeps what later blocks need of this one.
void TransportSweep::Impl::show(const Batch& with, size_t d, size_t block, const Scratch& s)
{
    const Frame& frame = with.frame[d];
    const Layout& layout = *frame.layout;
    Faces& to = shown[block * batch + d];
    for (int axis = 0; axis < 3; ++axis) {
        const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
        const int base = Layout::first + (frame.sign[axis] > 0 ? 8 : 1) * layout.stride[axis];
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) {
                const int from = base + (i + 1) * layout.stride[b] + (j + 1) * layout.stride[c];
                to.radiance[axis][i * 8 + j] = s.radiance[from];
                to.source[axis][i * 8 + j] = s.source[from];
            }
        if (outer_of[block][axis] < 0) continue;
        alignas(64) float sigma[64], q[64], length[64];
        const int q_base = (frame.sign[axis] > 0 ? 7 : 0) * layout.row_stride[axis];
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) {
                sigma[i * 8 + j] = s.sigma[base + (i + 1) * layout.stride[b] + (j + 1) * layout.stride[c]];
                q[i * 8 + j] = s.q[q_base + i * layout.row_stride[b] + j * layout.row_stride[c]];
                length[i * 8 + j] = frame.half_exit[axis];
            }
        block_sweep::leave(64, to.radiance[axis], sigma, q, length,
                           &outer[(size_t(outer_of[block][axis]) * batch + d) * 64]);
    }
}

void TransportSweep::Impl::tally(const Batch& with, size_t d, size_t block, const Scratch& s, SweepResult& result) const
{
    const Frame& frame = with.frame[d];
    const Layout& layout = *frame.layout;
    const Vec3d& direction = set->direction[with.direction[d]];
    const float weight = set->weight[with.direction[d]];
    constexpr size_t chunk = 64;
    alignas(64) float radiance[chunk] = {}, sigma[chunk] = {}, q[chunk] = {}, length[chunk] = {}, out[chunk];
    for (size_t first = first_face[block]; first < first_face[block + 1]; first += chunk) {
        const size_t count = std::min(chunk, first_face[block + 1] - first);
        for (size_t k = 0; k < count; ++k) {
            const SweepFace& face = faces[first + k];
            const int x = face.slot / 64 % 8, y = face.slot / 8 % 8, z = face.slot % 8, axis = face.face / 2;
            const int at = layout.at(x, y, z);
            const bool outward = (face.face % 2 ? 1 : -1) == frame.sign[axis];
            radiance[k] = s.radiance[outward ? at : at - frame.sign[axis] * layout.stride[axis]];
            sigma[k] = s.sigma[at];
            q[k] = s.q[x * layout.row_stride[0] + y * layout.row_stride[1] + z * layout.row_stride[2]];
            length[k] = outward ? frame.half_exit[axis] : 0.0f;
        }
        block_sweep::leave(int((count + 7) / 8 * 8), radiance, sigma, q, length, out);
        for (size_t k = 0; k < count; ++k) {
            const int face = faces[first + k].face;
            const float cosine = float(face % 2 ? direction[face / 2] : -direction[face / 2]), weighted = weight * out[k];
            FaceTally& to = result.tally[first + k];
            to.current += cosine * weighted;
            to.fluence += weighted;
            to.second += (cosine * cosine - 1.0f / 3) * weighted;
        }
    }
}

void TransportSweep::Impl::sweep_block(const Batch& with, size_t block, SweepResult& result)
{
    Scratch s;
    int32_t neighbour[regions];
    upstream(with.frame[0].sign, block, neighbour);
    const float* source[most_terms];
    float* moments[most_terms];
    for (int k = 0; k < set->source_terms; ++k) source[k] = (*fields->source)[k].data() + block * 512;
    for (int k = 0; k < set->moment_terms; ++k) moments[k] = result.moments[k].data() + block * 512;
    const Layout* loaded = nullptr;
    for (size_t d = 0; d < with.frame.size(); ++d) {
        const Frame& frame = with.frame[d];
        const size_t m = with.direction[d];
        if (loaded != frame.layout) load_sigma(frame, block, neighbour, s.sigma);
        loaded = frame.layout;
        block_sweep::prepare(frame, set->source_terms, source, &set->source_basis[m * set->source_terms], s);
        load_apron(with, d, block, neighbour, s);
        block_sweep::sweep_planes(frame, s);
        float weights[most_terms];
        for (int k = 0; k < set->moment_terms; ++k) weights[k] = set->weight[m] * set->moment_basis[m * set->moment_terms + k];
        block_sweep::accumulate(set->moment_terms, moments, weights, s.out);
        show(with, d, block, s);
        tally(with, d, block, s, result);
    }
}

TransportSweep::TransportSweep(const VoxelIndex& index, std::vector<SweepFace> faces)
    : impl_(std::make_unique<Impl>(index, std::move(faces)))
{}
TransportSweep::~TransportSweep() = default;

void TransportSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result)
{
    Impl& my = *impl_;
    if (set.source_terms < 1 || set.source_terms > most_terms || set.moment_terms < 0 || set.moment_terms > most_terms)
        throw InputError("a sweep of " + std::to_string(set.source_terms) + " source and " + std::to_string(set.moment_terms) +
                         " moment terms: expected 1 to 64");
    my.start(set, fields, result);
    for (int octant = 0; octant < 8; ++octant) {
        const auto sign = Impl::signs(octant);
        std::vector<Impl::Batch> batches;
        for (size_t m = 0; m < set.count(); ++m) {
            Vec3d step;
            for (int a = 0; a < 3; ++a) step[a] = set.direction[m][a] / my.index.spacing()[a];
            const Frame frame(step);
            if (frame.sign != sign) continue;
            if (batches.empty() || batches.back().frame.size() == batch) batches.emplace_back();
            batches.back().frame.push_back(frame);
            batches.back().step.push_back(step);
            batches.back().direction.push_back(m);
        }
        if (batches.empty()) continue;
        my.number_outer(sign);
        const Order& order = my.order[octant];
        for (const auto& each : batches)
            for (size_t level = 0; level + 1 < order.begin.size(); ++level)
                tbb::parallel_for(order.begin[level], order.begin[level + 1],
                                  [&](size_t n) { my.sweep_block(each, size_t(order.block[n]), result); });
    }
    for (size_t b = 0; b < my.blocks.count(); ++b)
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            if (!my.blocks.active(slot))
                for (auto& moment : result.moments) moment[slot] = 0;
}

size_t TransportSweep::bytes() const
{
    size_t total = impl_->blocks.count() * (batch * sizeof(Faces) + 3 * sizeof(int32_t) + 8 * sizeof(int32_t));
    return total + impl_->outer.size() * sizeof(float) + impl_->sky.size() + impl_->faces.size() * sizeof(SweepFace);
}

}  // namespace vdbcloud
