#include "vdbcloud/fractal/cloud_shape.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/fractal/noise_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

namespace vdbcloud {

namespace {

constexpr int B = block_edge;
constexpr int super = 4;  // edge of a group of blocks, which share a first selection of parts [blocks]
constexpr float nothing = -1e30f;

/// Everything the loops need, in world units and single precision.
struct Shaper {
    const fft::RealField<float>& noise;
    const Envelope& envelope;
    Vec3i size, shift[3];  // shifts of the copies of the noise that displace; none along the third axis
    Vec3f low, high, step;
    float roughness, warp, linear, fold, mean, edge, threshold;
    int up;
    bool limited;  // nothing beyond the envelope

    /// b(n) above.
    float bumps(float n) const { return linear * n + fold * std::abs(n) - mean; }

    Vec3f position(const Vec3i& ijk) const
    {
        return {low[0] + (float(ijk[0]) + 0.5f) * step[0], low[1] + (float(ijk[1]) + 0.5f) * step[1],
                low[2] + (float(ijk[2]) + 0.5f) * step[2]};
    }
    Vec3f block_centre(const Vec3i& origin, int edge_voxels) const
    {
        return position(origin) + 0.5f * float(edge_voxels - 1) * step;
    }
    /// From the centre to the centre of the outermost voxel.
    float block_radius(int edge_voxels) const { return 0.5f * float(edge_voxels - 1) * step.length(); }

    /// The part of a row of noise that belongs to a block, wrapped and clamped to the domain; beyond its end
    /// it is 0.
    const float* noise_row(int i, int j, int k, const Vec3i& by) const
    {
        i = std::min(i, size[0] - 1) + by[0];
        j = std::min(j, size[1] - 1) + by[1];
        return noise.row(i >= size[0] ? i - size[0] : i, j >= size[1] ? j - size[1] : j) + k;
    }
};

inline float clamped(float n)
{
    n = n < -most_noise ? -most_noise : n;
    return n > most_noise ? most_noise : n;
}

/// What is computed of one slice of a block, Stride-th voxels only: v + t, the envelope's own depth, and what
/// caps v, the height over the base and the distance to the faces of the domain.
template<int Stride>
struct Slice {
    static constexpr int n = B / Stride, count = n * n;
    float v[count], depth[count], cap[count];
    float x[count], y[count], z[count], noise[count];
};

template<int Stride>
__attribute__((always_inline)) inline void evaluate(const Shaper& s, const Envelope::Parts& near, const Vec3i& o,
                                                    Slice<Stride>& out)
{
    constexpr int n = Slice<Stride>::n;
    const Vec3f p = s.position(o);
    const float dy = s.step[1] * Stride, dz = s.step[2] * Stride, warp = s.warp;
    for (int j = 0; j < n; ++j) {
        const float* row = s.noise_row(o[0], o[1] + j * Stride, o[2], Vec3i(0));
        const float* a = s.noise_row(o[0], o[1] + j * Stride, o[2], s.shift[0]);
        const float* b = s.noise_row(o[0], o[1] + j * Stride, o[2], s.shift[1]);
        const float* c = s.noise_row(o[0], o[1] + j * Stride, o[2], s.shift[2]);
        const float px = p[0], py = p[1] + float(j) * dy, pz = p[2];
        const int q = j * n;
        for (int k = 0; k < n; ++k) {
            out.noise[q + k] = clamped(row[k * Stride]);
            out.x[q + k] = px + warp * clamped(a[k * Stride]);
            out.y[q + k] = py + warp * clamped(b[k * Stride]);
            out.z[q + k] = pz + float(k) * dz + warp * clamped(c[k * Stride]);
        }
    }
    s.envelope.depth(near, out.count, out.x, out.y, out.z, out.depth);
    const float base = s.envelope.base(), low_z = s.low[2], high_z = s.high[2];
    const float roughness = s.roughness, linear = s.linear, fold = s.fold, mean = s.mean;
    const float limit = s.limited ? 0 : -nothing;  // added to the depth, that of a cap that is none
    for (int j = 0; j < n; ++j) {
        const float py = p[1] + float(j) * dy;
        const float face =
            std::min(std::min(p[0] - s.low[0], s.high[0] - p[0]), std::min(py - s.low[1], s.high[1] - py));
        const float height = (s.up == 0 ? p[0] : s.up == 1 ? py : p[2]) - base, rise = s.up == 2 ? dz : 0;
        const int q = j * n;
        for (int k = 0; k < n; ++k) {
            const float pz = p[2] + float(k) * dz, depth = out.depth[q + k];
            const float bump = roughness * (linear * out.noise[q + k] + fold * std::abs(out.noise[q + k]) - mean);
            float cap = std::min(face, std::min(pz - low_z, high_z - pz));
            cap = std::min(cap, height + float(k) * rise + 0.2f * bump);
            out.v[q + k] = depth + bump;
            out.cap[q + k] = std::min(cap, depth + limit);
        }
    }
}

/// What bounds say of a block without evaluating its voxels.
enum class Kind { Empty, Full, Mixed };

/// Lists that a thread works with.
struct ThreadLists {
    Envelope::Parts group, near;
    std::vector<float> values;
};

float warp_reach(const Shaper& s) { return s.warp * most_noise * 1.7320508f; }

/// `lists.near` becomes the parts that matter in a block that is Mixed.
Kind classify(const Shaper& s, const NoiseBounds& bounds, const Vec3i& o, ThreadLists& lists)
{
    const Vec3f centre = s.block_centre(o, B);
    const auto n = bounds.over(o, Vec3i(0));
    const float zero = n.low <= 0 && n.high >= 0 ? s.bumps(0) : s.bumps(n.low);
    const float least = s.roughness * std::min(zero, std::min(s.bumps(n.low), s.bumps(n.high)));
    const float most = s.roughness * std::max(zero, std::max(s.bumps(n.low), s.bumps(n.high)));
    const float height = centre[s.up] - s.envelope.base(), reach = 0.5f * (B - 1) * s.step[s.up];
    if (height + reach + 0.2f * most <= 0) return Kind::Empty;

    Vec3f middle(0), spread(0);
    if (s.warp > 0)
        for (int d = 0; d < 3; ++d) {
            const auto w = bounds.over(o, s.shift[d]);
            middle[d] = s.warp * 0.5f * (w.low + w.high);
            spread[d] = s.warp * 0.5f * (w.high - w.low);
        }
    const float deepest_of_none = s.limited ? std::max(0.0f, s.threshold - most) : s.threshold - most;
    const auto depth = s.envelope.select(lists.group, {centre + middle, s.block_radius(B) + spread.length()},
                                         deepest_of_none, lists.near);
    if (depth.high + most <= s.threshold || (s.limited && depth.high <= 0)) return Kind::Empty;

    float face = 1e30f;
    for (int d = 0; d < 3; ++d)
        face = std::min(face, std::min(centre[d] - s.low[d], s.high[d] - centre[d]) - 0.5f * (B - 1) * s.step[d]);
    float v = std::min(depth.low + least - s.threshold, height - reach + 0.2f * least);
    if (s.limited) v = std::min(v, depth.low);
    return std::min(v, face) >= s.edge ? Kind::Full : Kind::Mixed;
}

/// Calls visit(origin, lists) for the blocks of the group at `corner`, with the parts that matter in
/// lists.group; skips a group whose depth is nowhere above `least`.
template<typename Visit>
void over_group(const Shaper& s, const Vec3i& corner, float least, ThreadLists& lists, const Visit& visit)
{
    constexpr int edge = super * B;
    const float radius = s.block_radius(edge) + warp_reach(s);
    if (s.envelope.select(s.envelope.all(), {s.block_centre(corner, edge), radius}, least, lists.group).high <= least)
        return;
    for (int i = 0; i < edge; i += B)
        for (int j = 0; j < edge; j += B)
            for (int k = 0; k < edge; k += B) {
                const Vec3i o = corner + Vec3i(i, j, k);
                if (o[0] < s.size[0] && o[1] < s.size[1] && o[2] < s.size[2]) visit(o);
            }
}

/// Calls visit(corner, index, lists) for every group of blocks, in parallel; index counts them in order of
/// their corners.
template<typename Visit>
void over_groups(const Shaper& s, const Progress& progress, const Visit& visit)
{
    constexpr int edge = super * B;
    const Vec3i n((s.size[0] + edge - 1) / edge, (s.size[1] + edge - 1) / edge, (s.size[2] + edge - 1) / edge);
    std::atomic<int> done{0};
    tbb::parallel_for(tbb::blocked_range<int>(0, n.product()), [&](const auto& range) {
        ThreadLists lists;
        for (int g = range.begin(); g != range.end(); ++g) {
            visit(edge * Vec3i(g / (n[1] * n[2]), g / n[2] % n[1], g % n[2]), size_t(g), lists);
            report(progress, double(++done) / n.product());
        }
    });
}

size_t group_count(const Vec3i& size)
{
    size_t count = 1;
    for (int d = 0; d < 3; ++d) count *= size_t((size[d] + super * B - 1) / (super * B));
    return count;
}

/// v at every second voxel of the envelope, along each axis.
std::vector<float> sample(const Shaper& s)
{
    std::vector<std::vector<float>> parts(group_count(s.size));
    over_groups(s, {}, [&](const Vec3i& corner, size_t g, ThreadLists& lists) {
        over_group(s, corner, 0, lists, [&](const Vec3i& o) {
            const float reach = s.block_radius(B) + warp_reach(s);
            if (s.envelope.select(lists.group, {s.block_centre(o, B), reach}, 0, lists.near).high <= 0) return;
            Slice<2> slice;
            for (int i = 0; i < B; i += 2) {
                evaluate<2>(s, lists.near, o + Vec3i(i, 0, 0), slice);
                for (int q = 0; q < slice.count; ++q)
                    if (slice.depth[q] > 0 && slice.cap[q] > 0) parts[g].push_back(slice.v[q]);
            }
        });
    });
    std::vector<float> values;
    for (const auto& part : parts) values.insert(values.end(), part.begin(), part.end());
    return values;
}

/// The value that a fraction `below` of the values does not exceed.
float quantile(std::vector<float>& values, double below)
{
    const auto rank = size_t(std::llround(below * double(values.size())));
    if (rank == 0) return nothing;
    const auto at = values.begin() + long(rank - 1);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// The density of a block, 512 values; false if all are 0.
VDBCLOUD_CLONES
bool fill_block(const Shaper& s, const Envelope::Parts& near, const Vec3i& o, float* values)
{
    Slice<1> slice;
    float most[B] = {};
    const float inverse = 1 / s.edge, threshold = s.threshold;
    for (int i = 0; i < B; ++i) {
        evaluate<1>(s, near, o + Vec3i(i, 0, 0), slice);
        for (int q = 0; q < slice.count; q += B)
            for (int l = 0; l < B; ++l) {
                float t = std::min(slice.v[q + l] - threshold, slice.cap[q + l]) * inverse;
                t = t < 0 ? 0 : t;
                t = t > 1 ? 1 : t;
                values[i * B * B + q + l] = t * t * (3 - 2 * t);
                most[l] = most[l] > t ? most[l] : t;
            }
    }
    return *std::max_element(most, most + B) > 0;
}

void fill(const Shaper& s, CloudBlocks& out, const Progress& progress)
{
    constexpr size_t voxels = size_t(B * B * B), most = voxels * super * super * super;
    const NoiseBounds bounds(s.noise);
    std::vector<std::vector<CloudBlocks::Block>> blocks(group_count(s.size));
    out.storage.resize(blocks.size());
    const float bump = s.roughness * std::max(std::abs(s.bumps(-most_noise)), std::abs(s.bumps(most_noise)));
    const float least = s.limited ? std::max(0.0f, s.threshold - bump) : s.threshold - bump;
    over_groups(s, progress, [&](const Vec3i& corner, size_t g, ThreadLists& lists) {
        lists.values.resize(most);
        size_t used = 0;
        std::vector<bool> full;
        over_group(s, corner, least, lists, [&](const Vec3i& o) {
            const auto kind = classify(s, bounds, o, lists);
            if (kind == Kind::Empty) return;
            if (kind == Kind::Mixed) {
                if (!fill_block(s, lists.near, o, lists.values.data() + used)) return;
                used += voxels;
            }
            blocks[g].push_back({o, nullptr});
            full.push_back(kind == Kind::Full);
        });
        out.storage[g].assign(lists.values.begin(), lists.values.begin() + long(used));
        const float* next = out.storage[g].data();
        for (size_t b = 0; b < full.size(); ++b)
            if (!full[b]) blocks[g][b].values = std::exchange(next, next + voxels);
    });
    for (const auto& group : blocks) out.blocks.insert(out.blocks.end(), group.begin(), group.end());
}

void check(const fft::RealField<float>& noise, const Box& domain, const ShapeOptions& o)
{
    const auto within = [](const char* name, double value, double most) {
        if (!(value >= 0 && value <= most))
            throw InputError(std::string(name) + " = " + std::to_string(value) + ": expected 0.." +
                             std::to_string(most));
    };
    within("roughness", o.roughness, 10);
    within("warp", o.warp, 1);
    within("billow", o.billow, 1);
    within("edge", o.edge, 1);
    if (o.coverage) within("coverage", *o.coverage, 1);
    for (int d = 0; d < 3; ++d)
        if (!(domain.sides()[d] > 0)) throw InputError("the domain's first corner is not below its second");
    if (noise.size().product() <= 0) throw InputError("noise without a voxel");
}

}  // namespace

CloudBlocks shape_cloud(const fft::RealField<float>& noise, const Box& domain, const Envelope& envelope,
                        const ShapeOptions& o, const Progress& progress)
{
    check(noise, domain, o);
    const Vec3i size = noise.size();
    const Vec3d sides = domain.sides(), step(sides[0] / size[0], sides[1] / size[1], sides[2] / size[2]);
    const double longest = std::max({sides[0], sides[1], sides[2]}), coarsest = std::max({step[0], step[1], step[2]});
    const double rms = std::sqrt(2 / pi);  // mean of |n|
    Shaper s{noise,
             envelope,
             size,
             {{size[0] / 3, size[1] / 2, 0}, {size[0] / 2, size[1] / 5, 0}, {size[0] * 5 / 6, size[1] * 3 / 4, 0}},
             Vec3f(domain.low),
             Vec3f(domain.high),
             Vec3f(step),
             float(o.roughness * longest),
             float(o.warp * longest),
             float(1 - o.billow),
             float(2 * o.billow),
             float(2 * o.billow * rms),
             float(std::max(o.edge * longest, 1.5 * coarsest)),
             0,
             o.up,
             o.coverage.has_value()};

    CloudBlocks out;
    out.size = size;
    out.domain = domain;
    if (o.coverage) {
        auto values = sample(s);
        if (values.empty()) throw InputError("the envelope holds no voxel of the domain");
        s.threshold = quantile(values, 1 - *o.coverage);
    }
    out.threshold = s.threshold;
    fill(s, out, progress);
    return out;
}

}  // namespace vdbcloud
