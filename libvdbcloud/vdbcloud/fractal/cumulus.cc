#include "vdbcloud/fractal/cumulus.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace vdbcloud {

namespace {

struct Sphere {
    Vec3d centre;  // third component up
    double radius;
    uint64_t id;  // what its children's random numbers are made from
};

double between(uint64_t bits, double low, double high) { return low + (high - low) * uniform(bits); }

/// Columns of spheres over the footprint, in a frame whose third axis is up and whose origin is the middle of
/// the base.
std::vector<Sphere> columns(const Vec3d& half, double height, const CumulusOptions& o)
{
    std::vector<Sphere> out;
    const double turn = between(hash_bits(o.seed, 1), 0, 2 * pi);
    for (int t = 0; t < o.towers; ++t) {
        const auto random = [&](int what, double low, double high) {
            return between(hash_bits(o.seed, 2, uint64_t(t), uint64_t(what)), low, high);
        };
        // The first stands near the middle, the others around it on a spiral, lower and slimmer the further
        // out.
        const double out_by = t == 0 ? random(0, 0.05, 0.3) : std::sqrt((t - 0.2) / o.towers) * random(0, 0.62, 0.8);
        const double angle = turn + golden_angle * t + random(1, -0.35, 0.35);
        const double top = height * (t == 0 ? 1 : (1.1 - 0.7 * out_by) * random(2, 0.5, 1));
        const double r0 = std::min(height * (t == 0 ? 0.5 : random(3, 0.3, 0.44)), 0.75 * top);
        const Vec3d foot(half[0] * out_by * std::cos(angle), half[1] * out_by * std::sin(angle), 0);
        const Vec3d lean(random(4, -0.2, 0.2), random(5, -0.2, 0.2), 0);
        const double dome = r0 * random(6, 0.65, 0.9);  // radius of the topmost
        const int count = std::max(2, int(std::lround((top - dome) / (0.5 * r0))));
        for (int s = 0; s < count; ++s) {
            const double f = double(s) / (count - 1);
            const double r = r0 + (dome - r0) * f;
            const double z = 0.35 * r0 + (top - dome - 0.35 * r0) * f;
            const uint64_t id = hash_bits(o.seed, 3, uint64_t(t), uint64_t(s));
            const Vec3d wobble(between(hash_bits(id, 1), -0.2, 0.2), between(hash_bits(id, 2), -0.2, 0.2), 0);
            out.push_back({foot + lean * z + wobble * r + Vec3d(0, 0, z), r, id});
        }
    }
    return out;
}

/// Smaller spheres on the outside of each of `parents`, evenly spread over it and a little disordered.
std::vector<Sphere> bulges(const std::vector<Sphere>& parents, int count, double low, double high)
{
    std::vector<Sphere> out;
    for (const auto& parent : parents) {
        const double turn = between(hash_bits(parent.id, 10), 0, 2 * pi);
        for (int c = 0; c < count; ++c) {
            const uint64_t id = hash_bits(parent.id, 11, uint64_t(c));
            const double z = std::clamp(1 - (2 * c + between(hash_bits(id, 1), 0, 2)) / count * 0.8, -1.0, 1.0);
            const double angle = turn + golden_angle * c + between(hash_bits(id, 2), -0.5, 0.5);
            const double flat = std::sqrt(1 - z * z), r = parent.radius * between(hash_bits(id, 3), low, high);
            const Vec3d w(flat * std::cos(angle), flat * std::sin(angle), z);
            const Sphere child{parent.centre + w * (parent.radius * between(hash_bits(id, 4), 0.82, 0.95)), r, id};
            if (child.centre[2] > -0.2 * r) out.push_back(child);
        }
    }
    return out;
}

/// Those of `children` that no sphere of `others` hides.
std::vector<Sphere> visible(const std::vector<Sphere>& children, const std::vector<Sphere>& others)
{
    std::vector<Sphere> out;
    for (const auto& c : children) {
        const bool hidden = std::any_of(others.begin(), others.end(), [&](const Sphere& o) {
            return (c.centre - o.centre).length() + 0.9 * c.radius < o.radius;
        });
        if (!hidden) out.push_back(c);
    }
    return out;
}

constexpr int lanes = 8;

/// The parts of a union of spheres: rows x, y, z, r / 2, 1 / (2 r), and one to work in, each of stride(count)
/// numbers. What pads a row to whole lanes is a sphere of no depth.
int stride(int count) { return (count + lanes - 1) / lanes * lanes; }

void resize(Envelope::Parts& parts, int count)
{
    parts.count = count;
    const size_t n = size_t(stride(count));
    if (parts.data.size() < 6 * n) parts.data.resize(6 * n);
}

void pad(Envelope::Parts& parts)
{
    const int n = stride(parts.count);
    for (int i = parts.count; i < n; ++i)
        for (int row = 0; row < 5; ++row) parts.data[size_t(row * n + i)] = row == 3 ? -1e30f : 0;
}

/// The largest least and most depth of any sphere over a ball; most[i] becomes that of sphere i.
VDBCLOUD_CLONES Envelope::Range bound(int n, const float* __restrict data, const Envelope::Ball& ball,
                                      float* __restrict most)
{
    const float x = ball.centre[0], y = ball.centre[1], z = ball.centre[2], radius = ball.radius;
    float low[lanes], high[lanes];
    std::fill_n(low, lanes, -1e30f);
    std::fill_n(high, lanes, -1e30f);
    for (int i = 0; i < n; i += lanes)
        for (int l = 0; l < lanes; ++l) {
            const float *s = data + i + l, a = s[0] - x, b = s[n] - y, c = s[2 * n] - z;
            const float d = std::sqrt(a * a + b * b + c * c), far = d + radius;
            const float near = d > radius ? d - radius : 0;
            const float m = s[3 * n] - near * near * s[4 * n], f = s[3 * n] - far * far * s[4 * n];
            most[i + l] = m;
            high[l] = m > high[l] ? m : high[l];
            low[l] = f > low[l] ? f : low[l];
        }
    return {*std::max_element(low, low + lanes), *std::max_element(high, high + lanes)};
}

/// out[p] = the largest depth of any sphere at point p.
VDBCLOUD_CLONES void deepest(int n, int spheres, const float* __restrict data, int count, const float* __restrict x,
                             const float* __restrict y, const float* __restrict z, float* __restrict out)
{
    int p = 0;
    for (; p + 2 * lanes <= count; p += 2 * lanes) {
        float most[2 * lanes];
        for (int l = 0; l < 2 * lanes; ++l) most[l] = -1e30f;
        for (int i = 0; i < spheres; ++i) {
            const float cx = data[i], cy = data[n + i], cz = data[2 * n + i], half_r = data[3 * n + i],
                        inverse = data[4 * n + i];
            for (int l = 0; l < 2 * lanes; ++l) {
                const float a = x[p + l] - cx, b = y[p + l] - cy, c = z[p + l] - cz;
                const float d = half_r - (a * a + b * b + c * c) * inverse;
                most[l] = d > most[l] ? d : most[l];
            }
        }
        for (int l = 0; l < 2 * lanes; ++l) out[p + l] = most[l];
    }
    for (; p < count; ++p) {
        out[p] = -1e30f;
        for (int i = 0; i < spheres; ++i) {
            const float a = x[p] - data[i], b = y[p] - data[n + i], c = z[p] - data[2 * n + i];
            const float d = data[3 * n + i] - (a * a + b * b + c * c) * data[4 * n + i];
            out[p] = d > out[p] ? d : out[p];
        }
    }
}

class Spheres : public Envelope {
public:
    Spheres(const std::vector<Sphere>& spheres, float base) : base_(base)
    {
        const int count = int(spheres.size()), n = stride(count);
        resize(all_, count);
        pad(all_);
        for (int i = 0; i < count; ++i) {
            const auto& s = spheres[size_t(i)];
            const double row[5] = {s.centre[0], s.centre[1], s.centre[2], s.radius / 2, 0.5 / s.radius};
            for (int r = 0; r < 5; ++r) all_.data[size_t(r * n + i)] = float(row[r]);
        }
    }

    const Parts& all() const override { return all_; }
    float base() const override { return base_; }

    Range select(const Parts& from, const Ball& ball, float least, Parts& near) const override
    {
        const int n = stride(from.count);
        resize(near, from.count);
        float* most = near.data.data() + 5 * n;
        const auto range = bound(n, from.data.data(), ball, most);
        const float cut = std::max(range.low, least);
        int count = 0;
        for (int i = 0; i < from.count; ++i) count += most[i] >= cut;
        const int m = stride(count);
        for (int i = 0, to = 0; i < from.count; ++i) {
            if (most[i] < cut) continue;
            for (int row = 0; row < 5; ++row) near.data[size_t(row * m + to)] = from.data[size_t(row * n + i)];
            ++to;
        }
        near.count = count;
        pad(near);
        return range;
    }

    void depth(const Parts& near, int count, const float* x, const float* y, const float* z, float* out) const override
    {
        deepest(stride(near.count), near.count, near.data.data(), count, x, y, z, out);
    }

private:
    Parts all_;
    float base_;
};

}  // namespace

EnvelopePtr cumulus_envelope(const Box& box, const CumulusOptions& o)
{
    if (o.towers < 1 || o.towers > 64) throw InputError("towers = " + std::to_string(o.towers) + ": expected 1..64");
    if (o.generations < 1 || o.generations > 4)
        throw InputError("generations = " + std::to_string(o.generations) + ": expected 1..4");
    const Vec3d sides = box.sides();
    const int up = o.up, u = (up + 1) % 3, v = (up + 2) % 3;

    const double height = std::min(sides[up], o.height * std::max(sides[u], sides[v]));
    auto parents = columns({0.5 * sides[u], 0.5 * sides[v], 0}, height, o);
    auto spheres = parents;
    const struct {
        int count;
        double low, high;
    } growth[] = {{12, 0.38, 0.62}, {11, 0.32, 0.5}, {8, 0.3, 0.5}};
    for (int g = 1; g < o.generations; ++g) {
        const auto& how = growth[g - 1];
        parents = visible(bulges(parents, how.count, how.low, how.high), spheres);
        spheres.insert(spheres.end(), parents.begin(), parents.end());
    }

    // Into the box: scaled alike on all axes, so that it fits, and set on its lower face.
    Vec3d low(1e30), high(-1e30);
    for (const auto& s : spheres)
        for (int d = 0; d < 3; ++d) {
            low[d] = std::min(low[d], s.centre[d] - s.radius);
            high[d] = std::max(high[d], s.centre[d] + s.radius);
        }
    const double scale = std::min({sides[u] / (high[0] - low[0]), sides[v] / (high[1] - low[1]), sides[up] / high[2]});
    const Vec3d middle = 0.5 * (low + high);
    for (auto& s : spheres) {
        Vec3d c;
        c[u] = box.centre()[u] + scale * (s.centre[0] - middle[0]);
        c[v] = box.centre()[v] + scale * (s.centre[1] - middle[1]);
        c[up] = box.low[up] + scale * s.centre[2];
        s.centre = c;
        s.radius *= scale;
    }
    return std::make_unique<Spheres>(spheres, float(box.low[up]));
}

}  // namespace vdbcloud
