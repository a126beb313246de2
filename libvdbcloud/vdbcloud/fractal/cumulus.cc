#include "vdbcloud/fractal/cumulus.h"

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
    uint64_t id;   // what its children's random numbers are made from
};

double between(uint64_t bits, double low, double high) { return low + (high - low) * uniform(bits); }

/// Columns of spheres over the footprint, in a frame whose third axis is up and whose origin is the middle of the base.
std::vector<Sphere> columns(const Vec3d& half, double height, const CumulusOptions& o)
{
    std::vector<Sphere> out;
    const double golden = 2.399963229728653, turn = between(hash_bits(o.seed, 1), 0, 2 * M_PI);
    for (int t = 0; t < o.towers; ++t) {
        const auto random = [&](int what, double low, double high) {
            return between(hash_bits(o.seed, 2, uint64_t(t), uint64_t(what)), low, high);
        };
        // The first stands near the middle, the others around it on a spiral, lower and slimmer the further out.
        const double out_by = t == 0 ? random(0, 0, 0.15) : std::sqrt((t - 0.2) / o.towers) * random(0, 0.62, 0.8);
        const double angle = turn + golden * t + random(1, -0.35, 0.35);
        const double top = height * (t == 0 ? 1 : (1.05 - 0.75 * out_by) * random(2, 0.5, 0.95));
        const double r0 = std::min(height * (t == 0 ? 0.42 : random(3, 0.3, 0.4)), 0.7 * top);
        const Vec3d foot(half[0] * out_by * std::cos(angle), half[1] * out_by * std::sin(angle), 0);
        const Vec3d lean(random(4, -0.2, 0.2), random(5, -0.2, 0.2), 0);
        const double dome = r0 * random(6, 0.55, 0.8);  // radius of the topmost
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
        const double turn = between(hash_bits(parent.id, 10), 0, 2 * M_PI);
        for (int c = 0; c < count; ++c) {
            const uint64_t id = hash_bits(parent.id, 11, uint64_t(c));
            const double z = std::clamp(1 - (2 * c + between(hash_bits(id, 1), 0, 2)) / count * 0.8, -1.0, 1.0);
            const double angle = turn + 2.399963229728653 * c + between(hash_bits(id, 2), -0.5, 0.5);
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

class Spheres : public Envelope {
public:
    Spheres(const std::vector<Sphere>& spheres, float base) : base_(base)
    {
        for (const auto& s : spheres) {
            for (int d = 0; d < 3; ++d) c_[d].push_back(float(s.centre[d]));
            half_r_.push_back(float(s.radius / 2));
            inverse_.push_back(float(0.5 / s.radius));
        }
    }

    Parts all() const override
    {
        Parts parts(half_r_.size());
        for (size_t i = 0; i < parts.size(); ++i) parts[i] = int(i);
        return parts;
    }

    Range select(const Parts& from, const Vec3f& centre, float radius, Parts& near) const override
    {
        Range range{-1e30f, -1e30f};
        near.clear();
        std::vector<float> high(from.size());
        for (size_t f = 0; f < from.size(); ++f) {
            const auto i = size_t(from[f]);
            const float d = (Vec3f(c_[0][i], c_[1][i], c_[2][i]) - centre).length();
            const float least = std::max(0.0f, d - radius), most = d + radius;
            high[f] = half_r_[i] - least * least * inverse_[i];
            range.high = std::max(range.high, high[f]);
            range.low = std::max(range.low, half_r_[i] - most * most * inverse_[i]);
        }
        for (size_t f = 0; f < from.size(); ++f)
            if (high[f] >= range.low) near.push_back(from[f]);
        return range;
    }

    void depth(const Parts& near, int count, const float* x, const float* y, const float* z, float* out) const override;
    float base() const override { return base_; }

private:
    std::vector<float> c_[3], half_r_, inverse_;
    float base_;
};

__attribute__((target_clones("avx2", "default")))
void deepest(int count, const float* __restrict x, const float* __restrict y, const float* __restrict z,
             float* __restrict out, const float* sphere)
{
    const float cx = sphere[0], cy = sphere[1], cz = sphere[2], half_r = sphere[3], inverse = sphere[4];
    for (int p = 0; p < count; ++p) {
        const float a = x[p] - cx, b = y[p] - cy, c = z[p] - cz;
        const float d = half_r - (a * a + b * b + c * c) * inverse;
        out[p] = out[p] > d ? out[p] : d;
    }
}

void Spheres::depth(const Parts& near, int count, const float* x, const float* y, const float* z, float* out) const
{
    std::fill_n(out, count, -1e30f);
    for (int part : near) {
        const auto i = size_t(part);
        const float sphere[5] = {c_[0][i], c_[1][i], c_[2][i], half_r_[i], inverse_[i]};
        deepest(count, x, y, z, out, sphere);
    }
}

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
    const struct { int count; double low, high; } growth[] = {{14, 0.34, 0.55}, {11, 0.3, 0.5}, {8, 0.3, 0.5}};
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
