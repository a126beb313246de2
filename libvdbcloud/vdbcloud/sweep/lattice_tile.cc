#include "vdbcloud/sweep/lattice_tile.h"

#include "vdbcloud/sweep/lanes.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

int ifloor(double x) { return int(std::floor(x)); }

/// Rows of rays that one step adds to: the taps' values of the first ray and row, and their weights.
struct Rows {
    int taps, count, stride;
    const float* from[LatticeTaps::most];
    float weight[LatticeTaps::most];
};

/// Adds the step of n x 8 rays of each row to their depths.
template<int n>
VDBCLOUD_INLINE void add_rows(const Rows& rows, double* depth)
{
    for (int j = 0; j < rows.count; ++j, depth += LatticeTile::rays) {
        lanes::Lanes sum[n];
        for (int k = 0; k < n; ++k) sum[k] = lanes::all(0);
        for (int t = 0; t < rows.taps; ++t) {
            const float* from = rows.from[t] + j * rows.stride;
            const lanes::Lanes weight = lanes::all(rows.weight[t]);
            for (int k = 0; k < n; ++k) sum[k] += weight * lanes::load(from + 8 * k);
        }
        for (int k = 0; k < n; ++k)
            for (int i = 0; i < 8; ++i) depth[8 * k + i] += double(sum[k][i]);
    }
}

VDBCLOUD_CLONES void add_rows(const Rows& rows, int eights, double* depth)
{
    if (eights == 4) return add_rows<4>(rows, depth);
    if (eights == 3) return add_rows<3>(rows, depth);
    if (eights == 2) return add_rows<2>(rows, depth);
    add_rows<1>(rows, depth);
}

}  // namespace

LatticeTile::LatticeTile(const BrickMap& density, const LatticeFrame& frame, const std::vector<double>& stops,
                         int rays_per_voxel, int a0, int b0)
    : density_(density), f_(frame), stops_(stops), r_(rays_per_voxel), a0_(a0), b0_(b0),
      depth_(size_t(r_) * r_ * rays * rays, 0.0)
{
}

void LatticeTile::advance(int n, size_t stop)
{
    const LatticeStep step(stops_, stop);
    const double w0 = n + step.from;
    bool any = false;
    for (int w = ifloor(w0); w <= ifloor(w0 + step.length) + 1; ++w) any = plane(w).any() || any;
    if (!any) return;
    for (int q = 0; q < r_; ++q)
        for (int p = 0; p < r_; ++p)
            add_step(step_taps(f_, double(p) / r_ + f_.mu * w0, double(q) / r_ + f_.mv * w0, w0, step.length),
                     phase(p, q));
}

/// Adds to the rays of one phase that meet values other than 0: of a brick with one voxel there are few.
void LatticeTile::add_step(const LatticeTaps& taps, double* depth)
{
    Rows rows{};
    int first = rays, last = -1, first_row = rays, last_row = -1;
    for (int k = 0; k < taps.count; ++k) {
        const LatticeTap& tap = taps.tap[size_t(k)];
        const Plane& from = plane(tap.dw);
        if (!from.any()) continue;
        const int u = a0_ + tap.du - from.u0, v = b0_ + tap.dv - from.v0;  // of ray and row 0
        first = std::min(first, from.u_low - u);
        last = std::max(last, from.u_high - u);
        first_row = std::min(first_row, from.v_low - v);
        last_row = std::max(last_row, from.v_high - v);
        rows.from[rows.taps] = from.value.data() + v * span + u;
        rows.weight[rows.taps++] = float(tap.weight);
    }
    first = std::max(first, 0);
    last = std::min(last, rays - 1);
    first_row = std::max(first_row, 0);
    rows.count = std::min(last_row, rays - 1) - first_row + 1;
    if (first > last || rows.count <= 0) return;
    products_ += size_t(rows.taps) * size_t(rows.count) * size_t(last - first + 1);
    const int begin = first & ~7;  // the rays about them add 0
    for (int t = 0; t < rows.taps; ++t) rows.from[t] += first_row * span + begin;
    rows.stride = span;
    add_rows(rows, last / 8 - begin / 8 + 1, depth + first_row * rays + begin);
}

size_t LatticeTile::values(int w)
{
    const Plane& p = plane(w);
    if (!p.any()) return 0;
    const int rows = std::min(rays - 1, p.v_high - margin) - std::max(0, p.v_low - margin) + 1;
    const int columns = std::min(rays - 1, p.u_high - margin) - std::max(0, p.u_low - margin) + 1;
    return rows > 0 && columns > 0 ? size_t(rows) * size_t(columns) : 0;
}

void LatticeTile::write(int n, const LatticeOffset& offset, const Vec3i& block, float* value) const
{
    const int k = f_.sign * (n - offset.shift) - 8 * block[f_.w];
    if (k < 0 || k > 7) return;
    const double w = n + offset.fraction, cu = offset.u - f_.mu * w, cv = offset.v - f_.mv * w;
    const int su = ifloor(cu), sv = ifloor(cv);
    const double fu = (cu - su) * r_, fv = (cv - sv) * r_;
    const int p = std::min(int(fu), r_ - 1), q = std::min(int(fv), r_ - 1);
    const double x = fu - p, y = fv - q;
    // The rays at phase (p + i, q + j); phase r is phase 0 of the next ray.
    const auto corner = [&](int i, int j) {
        return depth_.data() + ((q + j) % r_ * r_ + (p + i) % r_) * rays * rays + (q + j) / r_ * rays + (p + i) / r_;
    };
    const double *c00 = corner(0, 0), *c10 = corner(1, 0), *c01 = corner(0, 1), *c11 = corner(1, 1);
    constexpr int stride[3] = {64, 8, 1};
    const int a = 8 * block[f_.u] + su - a0_, b = 8 * block[f_.v] + sv - b0_;
    const int i_first = std::max(0, -a), i_end = std::min(8, tile - a);
    for (int j = std::max(0, -b); j < std::min(8, tile - b); ++j)
        for (int i = i_first; i < i_end; ++i) {
            const int at = (b + j) * rays + a + i;
            value[k * stride[f_.w] + j * stride[f_.v] + i * stride[f_.u]] =
                float((1 - y) * ((1 - x) * c00[at] + x * c10[at]) + y * ((1 - x) * c01[at] + x * c11[at]));
        }
}

void LatticeTile::Plane::clear()
{
    u_low = v_low = span;
    u_high = v_high = -1;
    value.fill(0);
}

/// Values `first`..`last` of row v.
void LatticeTile::Plane::copy_row(const float* from, int stride, int v, int first, int last)
{
    float* to = value.data() + v * span;
    for (int u = first; u <= last; ++u, from += stride) to[u] = *from;
    while (first <= last && to[first] == 0) ++first;
    while (first <= last && to[last] == 0) --last;
    if (first > last) return;
    u_low = std::min(u_low, first);
    u_high = std::max(u_high, last);
    v_low = std::min(v_low, v);
    v_high = std::max(v_high, v);
}

const LatticeTile::Plane& LatticeTile::plane(int w)
{
    Plane& p = planes_[size_t(w & 3)];
    if (p.valid && p.w == w) return p;
    p.valid = true;
    p.w = w;
    p.u0 = a0_ + ifloor(f_.mu * w) - margin;
    p.v0 = b0_ + ifloor(f_.mv * w) - margin;
    p.clear();
    const int k = f_.sign * w;
    constexpr int stride[3] = {BrickMap::sx, BrickMap::sy, 1};
    for (int bv = p.v0 >> 3; bv <= (p.v0 + span - 1) >> 3; ++bv)
        for (int bu = p.u0 >> 3; bu <= (p.u0 + span - 1) >> 3; ++bu) {
            Vec3i b;
            b[f_.u] = bu;
            b[f_.v] = bv;
            b[f_.w] = k >> 3;
            const float* brick = density_.find(b);
            if (!brick) continue;
            brick += (k & 7) * stride[f_.w];
            const int u_first = std::max(p.u0, bu * 8), u_last = std::min(p.u0 + span - 1, bu * 8 + 7);
            const int v_last = std::min(p.v0 + span - 1, bv * 8 + 7);
            for (int v = std::max(p.v0, bv * 8); v <= v_last; ++v)
                p.copy_row(brick + (v & 7) * stride[f_.v] + (u_first & 7) * stride[f_.u], stride[f_.u], v - p.v0,
                           u_first - p.u0, u_last - p.u0);
        }
    return p;
}

}  // namespace vdbcloud
