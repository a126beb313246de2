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

/// Where a block's upstream apron and its downstream centres lie in a padded block, for one octant and layout.
struct Places {
    Places(const Layout& layout, const std::array<int, 3>& sign);
    int count[regions];           ///< voxels of a region: 64, 8 or 1
    int16_t to[regions][64];      ///< in the padded block, in order of the coordinates that run
    int16_t slot[regions][64];    ///< in the neighbour, as a slot of its 512
    int8_t on_shown[regions][64];  ///< on the neighbour's face along the region's first axis
    int16_t last[3][64];          ///< downstream centres in the padded block, by axis
    int16_t last_row[3][64];      ///< the same in 512 values of the layout's order
};

Places::Places(const Layout& layout, const std::array<int, 3>& sign)
{
    for (int region = 0; region < regions; ++region) {
        int lo[3], hi[3], n = 0, c[3], e[3];
        for (int a = 0; a < 3; ++a) {
            const bool outside = region_axes[region] >> a & 1;
            lo[a] = outside ? (sign[a] > 0 ? -1 : 8) : 0;
            hi[a] = outside ? lo[a] : 7;
        }
        const int first_axis = region_axes[region] & 1 ? 0 : region_axes[region] & 2 ? 1 : 2;
        for (c[0] = lo[0]; c[0] <= hi[0]; ++c[0])
            for (c[1] = lo[1]; c[1] <= hi[1]; ++c[1])
                for (c[2] = lo[2]; c[2] <= hi[2]; ++c[2], ++n) {
                    for (int a = 0; a < 3; ++a) e[a] = c[a] & 7;
                    to[region][n] = int16_t(layout.at(c[0], c[1], c[2]));
                    slot[region][n] = int16_t(e[0] * 64 + e[1] * 8 + e[2]);
                    on_shown[region][n] = int8_t(on_face(first_axis, e));
                }
        count[region] = n;
    }
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 64; ++k) {
            int c[3];
            c[axis] = sign[axis] > 0 ? 7 : 0;
            c[axis == 0 ? 1 : 0] = k / 8;
            c[axis == 2 ? 1 : 2] = k % 8;
            last[axis][k] = int16_t(layout.at(c[0], c[1], c[2]));
            last_row[axis][k] = int16_t(c[0] * layout.row_stride[0] + c[1] * layout.row_stride[1] + c[2] * layout.row_stride[2]);
        }
}

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
        for (const Layout* layout : {&block_sweep::natural, &block_sweep::turned})
            for (int octant = 0; octant < 8; ++octant) place.emplace_back(*layout, signs(octant));
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
    struct Patch;
    float radiance_at(const Batch&, size_t d, const VoidRays::Hit&) const;
    bool fill_patch(Patch&, const int* lo, const int* hi, float* radiance) const;
    const Places& places(const Frame& frame) const
    {
        return place[(frame.sign[0] < 0) * 4 + (frame.sign[1] < 0) * 2 + (frame.sign[2] < 0) + 8 * (frame.w == 2)];
    }
    void show(const Batch&, size_t d, size_t block, const Scratch&);
    void tally(const Batch&, size_t d, size_t block, const Scratch&, SweepResult&) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    std::vector<SweepFace> faces;
    std::vector<size_t> first_face;  // of each block
    VoidRays rays;
    Order order[8];
    std::vector<Places> place;  // of each octant, for the natural layout and then for the turned one
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

void TransportSweep::Impl::load_sigma(const Frame& frame, size_t block, const int32_t* neighbour, float* padded) const
{
    const Places& at = places(frame);
    const float* sigma = fields->sigma_t->data();
    block_sweep::load_inside(*frame.layout, sigma + block * 512, padded);
    for (int region = 0; region < regions; ++region) {
        const float* from = neighbour[region] < 0 ? nullptr : sigma + size_t(neighbour[region]) * 512;
        for (int k = 0; k < at.count[region]; ++k) padded[at.to[region][k]] = from ? from[at.slot[region][k]] : 0.0f;
    }
}

/// A region of the apron of a missing block, for one direction: voxels c with c[a] running along `along`.
struct TransportSweep::Impl::Patch {
    const Batch* with;
    size_t d;
    Vec3d corner;   // its first voxel, in block coordinates
    int along[2];   // axes; -1: none
    int stride[2];  // in `radiance` and `hit`
    uint64_t traced = 0;  // which of the hits are known
    VoidRays::Hit hit[64];

    const VoidRays::Hit& trace(const VoidRays& rays, int i, int j)
    {
        const int k = i * stride[0] + j * stride[1];
        if (!(traced >> k & 1)) {
            Vec3d from = corner;
            if (along[0] >= 0) from[along[0]] += i;
            if (along[1] >= 0) from[along[1]] += j;
            hit[k] = rays.trace(from, with->step[d]);
            traced |= uint64_t(1) << k;
        }
        return hit[k];
    }
};

/// What a ray brings from where it ends.
float TransportSweep::Impl::radiance_at(const Batch& with, size_t d, const VoidRays::Hit& hit) const
{
    if (hit.block < 0) return set->inflow.empty() ? 0.0f : set->inflow[with.direction[d]];
    const Vec3d& step = with.step[d];
    float sum = 0;
    int faces_met = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(hit.axes >> axis & 1)) continue;
        int cell[2];
        float f[2];
        for (int k = 0; k < 2; ++k) {  // light met the centres' plane half a step before
            const int other = k == 0 ? (axis == 0 ? 1 : 0) : (axis == 2 ? 1 : 2);
            const double on = std::clamp(hit.at[other] - 0.5 * step[other] / std::abs(step[axis]), 0.0, 7.0);
            cell[k] = std::min(int(on), 6);
            f[k] = float(on - cell[k]);
        }
        const size_t block = size_t(hit.block);  // a ray through an edge may meet a face that touches another block
        const float* face = outer_of[block][axis] < 0 ? shown[block * batch + d].radiance[axis]
                                                      : &outer[(size_t(outer_of[block][axis]) * batch + d) * 64];
        const float* from = face + cell[0] * 8 + cell[1];
        sum += (1 - f[0]) * ((1 - f[1]) * from[0] + f[1] * from[1]) + f[0] * ((1 - f[1]) * from[8] + f[1] * from[9]);
        ++faces_met;
    }
    return sum / float(faces_met);
}

/// Fills the voxels lo..hi of a patch; true if all of it is sky.
///
/// Rays are parallel and a block is wider than any patch, so that whatever blocks one of them blocks one at a corner:
/// where the corners' rays end on one face, or all in the sky, so do all between.
bool TransportSweep::Impl::fill_patch(Patch& patch, const int* lo, const int* hi, float* radiance) const
{
    const Vec3d& step = patch.with->step[patch.d];
    VoidRays::Hit first;
    bool one = true;
    for (int c = 0; c < 4 && one; ++c) {
        if ((c & 1 && lo[0] == hi[0]) || (c & 2 && lo[1] == hi[1])) continue;
        const VoidRays::Hit& hit = patch.trace(rays, c & 1 ? hi[0] : lo[0], c & 2 ? hi[1] : lo[1]);
        if (c == 0) first = hit;
        one = hit.block == first.block && hit.axes == first.axes;
    }
    const bool on_edge = first.axes & (first.axes - 1);
    if (on_edge) one = lo[0] == hi[0] && lo[1] == hi[1];
    if (!one) {
        const int k = hi[0] - lo[0] >= hi[1] - lo[1] ? 0 : 1, middle = (lo[k] + hi[k]) / 2;
        int upper_lo[2] = {lo[0], lo[1]}, lower_hi[2] = {hi[0], hi[1]};
        lower_hi[k] = middle;
        upper_lo[k] = middle + 1;
        const bool lower_sky = fill_patch(patch, lo, lower_hi, radiance);
        return fill_patch(patch, upper_lo, hi, radiance) && lower_sky;
    }
    double slope[2][3] = {{0, 0, 0}, {0, 0, 0}};  // how the end moves with the start
    for (int k = 0; k < 2 && first.block >= 0 && !on_edge; ++k) {
        const int axis = first.axes >> 1;  // 1, 2, 4: 0, 1, 2
        for (int a = 0; a < 3 && patch.along[k] >= 0; ++a)
            if (a != axis) slope[k][a] = a == patch.along[k] ? 1.0 : patch.along[k] == axis ? -step[a] / step[axis] : 0.0;
    }
    for (int i = lo[0]; i <= hi[0]; ++i)
        for (int j = lo[1]; j <= hi[1]; ++j) {
            VoidRays::Hit hit = first;
            for (int a = 0; a < 3; ++a) hit.at[a] += slope[0][a] * (i - lo[0]) + slope[1][a] * (j - lo[1]);
            radiance[i * patch.stride[0] + j * patch.stride[1]] = radiance_at(*patch.with, patch.d, hit);
        }
    return first.block < 0;
}

void TransportSweep::Impl::load_apron(const Batch& with, size_t d, size_t block, const int32_t* neighbour, Scratch& s)
{
    const Frame& frame = with.frame[d];
    const Places& at = places(frame);
    uint8_t& known = sky[with.direction[d] * blocks.count() + block];
    for (int region = 0; region < regions; ++region) {
        const int count = at.count[region];
        if (neighbour[region] >= 0) {
            const Faces& from = shown[size_t(neighbour[region]) * batch + d];
            const int axis = region_axes[region] & 1 ? 0 : region_axes[region] & 2 ? 1 : 2;
            for (int k = 0; k < count; ++k) {
                s.radiance[at.to[region][k]] = from.radiance[axis][at.on_shown[region][k]];
                s.source[at.to[region][k]] = from.source[axis][at.on_shown[region][k]];
            }
            continue;
        }
        float radiance[64];
        if (known >> region & 1) {
            std::fill_n(radiance, count, set->inflow.empty() ? 0.0f : set->inflow[with.direction[d]]);
        } else {
            Patch patch;
            patch.with = &with;
            patch.d = d;
            patch.along[0] = patch.along[1] = -1;
            int lo[2] = {0, 0}, hi[2] = {0, 0}, runs = 0;
            for (int a = 0; a < 3; ++a) {
                const bool outside = region_axes[region] >> a & 1;
                patch.corner[a] = 8 * blocks.at(block)[a] + (outside ? (frame.sign[a] > 0 ? -1 : 8) : 0);
                if (outside) continue;
                patch.along[runs] = a;
                hi[runs++] = 7;
            }
            patch.stride[0] = runs == 2 ? 8 : 1;
            patch.stride[1] = 1;
            if (fill_patch(patch, lo, hi, radiance)) known = uint8_t(known | 1 << region);
        }
        for (int k = 0; k < count; ++k) {
            s.radiance[at.to[region][k]] = radiance[k];
            s.source[at.to[region][k]] = 0;
        }
    }
}

/// Keeps what later blocks need of this one.
void TransportSweep::Impl::show(const Batch& with, size_t d, size_t block, const Scratch& s)
{
    const Frame& frame = with.frame[d];
    const Places& at = places(frame);
    Faces& to = shown[block * batch + d];
    for (int axis = 0; axis < 3; ++axis) {
        for (int k = 0; k < 64; ++k) {
            to.radiance[axis][k] = s.radiance[at.last[axis][k]];
            to.source[axis][k] = s.source[at.last[axis][k]];
        }
        if (outer_of[block][axis] < 0) continue;
        alignas(64) float sigma[64], q[64], length[64];
        for (int k = 0; k < 64; ++k) {
            sigma[k] = s.sigma[at.last[axis][k]];
            q[k] = s.q[at.last_row[axis][k]];
            length[k] = frame.half_exit[axis];
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
        for (size_t n = 0; n < 2 * set.count(); ++n) {  // those of one layout after those of the other
            const size_t m = n % set.count();
            Vec3d step;
            for (int a = 0; a < 3; ++a) step[a] = set.direction[m][a] / my.index.spacing()[a];
            const Frame frame(step);
            if (frame.sign != sign || (frame.w == 2) != (n >= set.count())) continue;
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
