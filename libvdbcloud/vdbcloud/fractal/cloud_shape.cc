#include "vdbcloud/fractal/cloud_shape.h"

#include "vdbcloud/core/error.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <utility>

namespace vdbcloud {

namespace {

constexpr int B = 8;             // edge of a block [voxels]
constexpr int super = 4;         // edge of a group of blocks, for which the parts that matter are selected once [blocks]
constexpr float most_noise = 4;  // noise is clamped here, as bounds are needed
constexpr float nothing = -1e30f;

struct Range {
    float low, high;
};

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

    /// The part of a row of noise that belongs to a block, wrapped and clamped to the domain.
    const float* noise_row(int i, int j, int k, const Vec3i& by) const
    {
        i = std::min(i, size[0] - 1) + by[0];
        j = std::min(j, size[1] - 1) + by[1];
        return noise.row(i >= size[0] ? i - size[0] : i, j >= size[1] ? j - size[1] : j) + k;
    }
};

Range noise_range(const Shaper& s, const Vec3i& o, const Vec3i& by)
{
    const int width = std::min(B, s.size[2] - o[2]);
    float low[B], high[B];
    std::fill_n(low, B, most_noise);
    std::fill_n(high, B, -most_noise);
    for (int i = 0; i < B; ++i)
        for (int j = 0; j < B; ++j) {
            const float* row = s.noise_row(o[0] + i, o[1] + j, o[2], by);
            if (width == B) {
                for (int k = 0; k < B; ++k) {
                    low[k] = std::min(low[k], row[k]);
                    high[k] = std::max(high[k], row[k]);
                }
            } else {
                for (int k = 0; k < width; ++k) {
                    low[k] = std::min(low[k], row[k]);
                    high[k] = std::max(high[k], row[k]);
                }
            }
        }
    return {std::max(-most_noise, *std::min_element(low, low + B)), std::min(most_noise, *std::max_element(high, high + B))};
}

/// v(x) + t of every Stride-th voxel of one slice of a block, the envelope's own depth there, and what caps v: the
/// height over the base and the distance to the faces of the domain.
template<int Stride>
void evaluate(const Shaper& s, const Envelope::Parts& near, const Vec3i& o, float* v, float* depth, float* cap)
{
    constexpr int n = B / Stride, count = n * n;
    float x[count], y[count], z[count], noise[count], other[3][count];
    const Vec3f p = s.position(o);
    const int width = std::min(B, s.size[2] - o[2]);
    for (int j = 0; j < n; ++j) {
        const float* row = s.noise_row(o[0], o[1] + j * Stride, o[2], Vec3i(0));
        const float* shifted[3];
        for (int d = 0; d < 3; ++d) shifted[d] = s.noise_row(o[0], o[1] + j * Stride, o[2], s.shift[d]);
        for (int k = 0; k < n; ++k) {
            const int at = std::min(k * Stride, width - 1), q = j * n + k;
            noise[q] = row[at];
            for (int d = 0; d < 3; ++d) other[d][q] = shifted[d][at];
        }
    }
    const auto clamp = [](float f) {
        f = f < -most_noise ? -most_noise : f;
        return f > most_noise ? most_noise : f;
    };
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
            const int q = j * n + k;
            noise[q] = clamp(noise[q]);
            x[q] = p[0] + s.warp * clamp(other[0][q]);
            y[q] = p[1] + float(j * Stride) * s.step[1] + s.warp * clamp(other[1][q]);
            z[q] = p[2] + float(k * Stride) * s.step[2] + s.warp * clamp(other[2][q]);
        }
    s.envelope.depth(near, count, x, y, z, depth);
    const float px = std::min(p[0] - s.low[0], s.high[0] - p[0]), base = s.envelope.base();
    for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
            const int q = j * n + k;
            const float py = p[1] + float(j * Stride) * s.step[1], pz = p[2] + float(k * Stride) * s.step[2];
            const float face = std::min(px, std::min(std::min(py - s.low[1], s.high[1] - py),
                                                     std::min(pz - s.low[2], s.high[2] - pz)));
            const float bump = s.roughness * s.bumps(noise[q]);
            const float height = s.up == 0 ? p[0] : s.up == 1 ? py : pz;
            v[q] = depth[q] + bump;
            cap[q] = std::min(height - base + 0.2f * bump, face);
            if (s.limited) cap[q] = std::min(cap[q], depth[q]);
        }
}

/// What is known of a block before its voxels are looked at.
enum class Kind { Empty, Full, Mixed };

Kind classify(const Shaper& s, const Envelope::Parts& from, const Vec3i& o, Envelope::Parts& near)
{
    const Vec3f centre = s.block_centre(o, B);
    const float bump = s.roughness * std::max(std::abs(s.bumps(-most_noise)), std::abs(s.bumps(most_noise)));
    const float radius = s.block_radius(B);
    const auto far = s.envelope.select(from, centre, radius + s.warp * most_noise * 1.7320508f, near);
    if (far.high + bump <= s.threshold) return Kind::Empty;

    const auto n = noise_range(s, o, Vec3i(0));
    const float zero = n.low <= 0 && n.high >= 0 ? s.bumps(0) : s.bumps(n.low);
    const float least = std::min(zero, std::min(s.bumps(n.low), s.bumps(n.high)));
    const float most = std::max(zero, std::max(s.bumps(n.low), s.bumps(n.high)));
    Vec3f middle(0), spread(0);
    if (s.warp > 0)
        for (int d = 0; d < 3; ++d) {
            const auto w = noise_range(s, o, s.shift[d]);
            middle[d] = s.warp * 0.5f * (w.low + w.high);
            spread[d] = s.warp * 0.5f * (w.high - w.low);
        }
    const Envelope::Parts candidates = near;
    const auto depth = s.envelope.select(candidates, centre + middle, radius + spread.length(), near);
    if (depth.high + s.roughness * most <= s.threshold || (s.limited && depth.high <= 0)) return Kind::Empty;

    const float height = centre[s.up] - s.envelope.base(), reach = 0.5f * (B - 1) * s.step[s.up];
    if (height + reach + 0.2f * s.roughness * most <= 0) return Kind::Empty;
    float face = 1e30f;
    for (int d = 0; d < 3; ++d)
        face = std::min(face, std::min(centre[d] - s.low[d], s.high[d] - centre[d]) - 0.5f * (B - 1) * s.step[d]);
    float v = std::min(depth.low + s.roughness * least - s.threshold, height - reach + 0.2f * s.roughness * least);
    if (s.limited) v = std::min(v, depth.low);
    return std::min(v, face) >= s.edge ? Kind::Full : Kind::Mixed;
}

/// Calls visit(origin, parts that may matter) for the blocks of the group at `corner`.
template<typename Visit>
void over_group(const Shaper& s, const Envelope::Parts& all, const Vec3i& corner, const Visit& visit)
{
    constexpr int edge = super * B;
    Envelope::Parts near;
    s.envelope.select(all, s.block_centre(corner, edge), s.block_radius(edge) + s.warp * most_noise * 1.7320508f, near);
    for (int i = 0; i < edge; i += B)
        for (int j = 0; j < edge; j += B)
            for (int k = 0; k < edge; k += B) {
                const Vec3i o = corner + Vec3i(i, j, k);
                if (o[0] < s.size[0] && o[1] < s.size[1] && o[2] < s.size[2]) visit(o, near);
            }
}

/// Calls visit(corner, index) for every group of blocks, in parallel; index counts them in order of their corners.
template<typename Visit> void over_groups(const Shaper& s, const Progress& progress, const Visit& visit)
{
    constexpr int edge = super * B;
    const Vec3i n((s.size[0] + edge - 1) / edge, (s.size[1] + edge - 1) / edge, (s.size[2] + edge - 1) / edge);
    std::atomic<int> done{0};
    tbb::parallel_for(0, n.product(), [&](int g) {
        visit(edge * Vec3i(g / (n[1] * n[2]), g / n[2] % n[1], g % n[2]), size_t(g));
        report(progress, double(++done) / n.product());
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
    const auto all = s.envelope.all();
    over_groups(s, {}, [&](const Vec3i& corner, size_t g) {
        over_group(s, all, corner, [&](const Vec3i& o, const Envelope::Parts& from) {
            Envelope::Parts near;
            const float reach = s.block_radius(B) + s.warp * most_noise * 1.7320508f;
            if (s.envelope.select(from, s.block_centre(o, B), reach, near).high <= 0) return;
            constexpr int n = B / 2;
            float v[n * n], depth[n * n], cap[n * n];
            for (int i = 0; i < B; i += 2) {
                evaluate<2>(s, near, o + Vec3i(i, 0, 0), v, depth, cap);
                for (int q = 0; q < n * n; ++q)
                    if (depth[q] > 0 && cap[q] > 0) parts[g].push_back(v[q]);
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
bool fill_block(const Shaper& s, const Envelope::Parts& near, const Vec3i& o, float* values)
{
    float v[B * B], depth[B * B], cap[B * B], most = 0;
    const float inverse = 1 / s.edge;
    for (int i = 0; i < B; ++i) {
        evaluate<1>(s, near, o + Vec3i(i, 0, 0), v, depth, cap);
        for (int q = 0; q < B * B; ++q) {
            float t = std::min(v[q] - s.threshold, cap[q]) * inverse;
            t = t < 0 ? 0 : t;
            t = t > 1 ? 1 : t;
            values[i * B * B + q] = t * t * (3 - 2 * t);
            most = most > t ? most : t;
        }
    }
    return most > 0;
}

void fill(const Shaper& s, CloudBlocks& out, const Progress& progress)
{
    std::vector<std::vector<CloudBlocks::Block>> blocks(group_count(s.size));
    out.storage.resize(blocks.size());
    const auto all = s.envelope.all();
    over_groups(s, progress, [&](const Vec3i& corner, size_t g) {
        Envelope::Parts near;
        std::vector<float> values;
        std::vector<bool> full;
        over_group(s, all, corner, [&](const Vec3i& o, const Envelope::Parts& from) {
            const auto kind = classify(s, from, o, near);
            if (kind == Kind::Empty) return;
            if (kind == Kind::Mixed) {
                const size_t at = values.size();
                values.resize(at + B * B * B);
                if (!fill_block(s, near, o, values.data() + at)) {
                    values.resize(at);
                    return;
                }
            }
            blocks[g].push_back({o, nullptr});
            full.push_back(kind == Kind::Full);
        });
        values.shrink_to_fit();
        const float* next = values.data();
        for (size_t b = 0; b < full.size(); ++b)
            if (!full[b]) blocks[g][b].values = std::exchange(next, next + B * B * B);
        out.storage[g] = std::move(values);
    });
    for (const auto& group : blocks) out.blocks.insert(out.blocks.end(), group.begin(), group.end());
}

void check(const fft::RealField<float>& noise, const Box& domain, const ShapeOptions& o)
{
    const auto within = [](const char* name, double value, double most) {
        if (!(value >= 0 && value <= most))
            throw InputError(std::string(name) + " = " + std::to_string(value) + ": expected 0.." + std::to_string(most));
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
    const double rms = std::sqrt(2 / M_PI);  // mean of |n|
    Shaper s{noise, envelope, size,
             {{size[0] / 3, size[1] / 2, 0}, {size[0] / 2, size[1] / 5, 0}, {size[0] * 5 / 6, size[1] * 3 / 4, 0}},
             Vec3f(domain.low), Vec3f(domain.high), Vec3f(step),
             float(o.roughness * longest), float(o.warp * longest), float(1 - o.billow), float(2 * o.billow),
             float(2 * o.billow * rms), float(std::max(o.edge * longest, 1.5 * coarsest)), 0, o.up, o.coverage.has_value()};

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
