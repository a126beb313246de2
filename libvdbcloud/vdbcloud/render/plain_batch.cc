#include "vdbcloud/render/plain_batch.h"

#include "vdbcloud/render/forward_peak.h"
#include "vdbcloud/render/lane_math.h"
#include "vdbcloud/voxels/brick_map.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

using namespace lanes4;

constexpr int most_groups = most_plain_fields / 4;

/// Corner values of four cells: lane n of the k-th vector is corner k of cell n.
VDBCLOUD_INLINE void transposed(const float (*corner)[8], Lanes* to)
{
    for (int h = 0; h < 2; ++h) {
        const Floats a = floats(corner[0] + 4 * h), b = floats(corner[1] + 4 * h), c = floats(corner[2] + 4 * h),
                     d = floats(corner[3] + 4 * h);
        const Floats ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
        const Floats ab2 = __builtin_shufflevector(a, b, 2, 6, 3, 7), cd2 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
        to[4 * h] = wide(__builtin_shufflevector(ab, cd, 0, 1, 4, 5));
        to[4 * h + 1] = wide(__builtin_shufflevector(ab, cd, 2, 3, 6, 7));
        to[4 * h + 2] = wide(__builtin_shufflevector(ab2, cd2, 0, 1, 4, 5));
        to[4 * h + 3] = wide(__builtin_shufflevector(ab2, cd2, 2, 3, 6, 7));
    }
}

constexpr int offsets[8] = {0,
                            1,
                            BrickMap::sy,
                            BrickMap::sy + 1,
                            BrickMap::sx,
                            BrickMap::sx + 1,
                            BrickMap::sx + BrickMap::sy,
                            BrickMap::sx + BrickMap::sy + 1};

/// What the fields of a node say.
template<int Groups>
VDBCLOUD_INLINE void interpret(const PlainRay& ray, PlainBatch& b, const Lanes* value, int point, int i)
{
    const int groups = Groups > 0 ? Groups : ray.groups;
    for (int l = 0; l < ray.lights; ++l) b.depth[size_t(l)][size_t(point)][size_t(i)] = value[l / 4][l % 4];
    for (int c = 0; c < ray.channels; ++c) {
        Lanes folded = all(0);
        for (int g = 0; g < groups; ++g) folded += load(ray.weight[c].data() + 4 * g) * value[g];
        double light = sum(folded);
        if (ray.flux_limit > 0 && ray.flux[c] >= 0) {
            const auto at = [&](int k) { return value[k / 4][k % 4]; };
            const double phi = at(ray.phi[c]), x = at(ray.flux[c]), y = at(ray.flux[c] + 1), z = at(ray.flux[c] + 2);
            const double square = x * x + y * y + z * z, longest = ray.flux_limit * std::max(phi, 0.0);
            if (square > longest * longest) {
                const double* w = ray.weight[c].data() + ray.flux[c];
                light += (longest / std::sqrt(square) - 1) * (w[0] * x + w[1] * y + w[2] * z);
            }
        }
        b.collided[c][size_t(point)][size_t(i)] = light;
    }
}

/// Fields where the ray enters cell i. Lanes of the last group beyond the last field are cleared by `mask`.
template<int Groups>
VDBCLOUD_INLINE void gather_start(const PlainRay& ray, PlainBatch& b, Ints mask, int i)
{
    const int groups = Groups > 0 ? Groups : ray.groups;
    const double x = b.local[0][i], y = b.local[1][i], z = b.local[2][i];
    Lanes start[Groups > 0 ? Groups : most_groups];
    for (int g = 0; g < groups; ++g) {
        Lanes s = all(0);
        for (int k = 0; k < 8; ++k)
            s += all((k & 4 ? x : 1 - x) * ((k & 2 ? y : 1 - y) * (k & 1 ? z : 1 - z))) *
                 wide(floats(b.field[i] + offsets[k] * ray.fields + 4 * g));
        start[g] = g == groups - 1 ? as_lanes(as_ints(s) & mask) : s;
    }
    interpret<Groups>(ray, b, start, 0, i);
}

template<int Groups>
VDBCLOUD_INLINE void gather_cells(const PlainRay& ray, PlainBatch& b, int lit)
{
    const int groups = Groups > 0 ? Groups : ray.groups;
    const int64_t used = ray.fields - 4 * (groups - 1);
    const Ints mask = {used > 0 ? -1 : 0, used > 1 ? -1 : 0, used > 2 ? -1 : 0, used > 3 ? -1 : 0};
    for (int i = 0; i < lit; ++i) {
        Lanes mid[Groups > 0 ? Groups : most_groups], end[Groups > 0 ? Groups : most_groups];
        for (int g = 0; g < groups; ++g) {
            Lanes m = all(0), e = all(0);
            for (int k = 0; k < 8; ++k) {
                const Lanes v = wide(floats(b.field[i] + offsets[k] * ray.fields + 4 * g));
                m += all(b.weight[k][i]) * v;
                e += all(b.weight[8 + k][i]) * v;
            }
            mid[g] = g == groups - 1 ? as_lanes(as_ints(m) & mask) : m;
            end[g] = g == groups - 1 ? as_lanes(as_ints(e) & mask) : e;
        }
        interpret<Groups>(ray, b, mid, 1, i);
        interpret<Groups>(ray, b, end, 2, i);
        if (!b.joined[i]) {
            gather_start<Groups>(ray, b, mask, i);
            continue;
        }
        for (int l = 0; l < ray.lights; ++l) b.depth[size_t(l)][0][size_t(i)] = b.depth[size_t(l)][2][size_t(i - 1)];
        for (int c = 0; c < ray.channels; ++c) b.collided[c][0][size_t(i)] = b.collided[c][2][size_t(i - 1)];
    }
}

VDBCLOUD_CLONES void gather_1(const PlainRay& ray, PlainBatch& b, int lit) { gather_cells<1>(ray, b, lit); }
VDBCLOUD_CLONES void gather_2(const PlainRay& ray, PlainBatch& b, int lit) { gather_cells<2>(ray, b, lit); }
VDBCLOUD_CLONES void gather_3(const PlainRay& ray, PlainBatch& b, int lit) { gather_cells<3>(ray, b, lit); }
VDBCLOUD_CLONES void gather_4(const PlainRay& ray, PlainBatch& b, int lit) { gather_cells<4>(ray, b, lit); }
VDBCLOUD_CLONES void gather_any(const PlainRay& ray, PlainBatch& b, int lit) { gather_cells<0>(ray, b, lit); }

/// The factor of the forward peak at four depths.
VDBCLOUD_INLINE Lanes peak_at(const double* row, Lanes x)
{
    x = x < all(0) ? all(0) : x;
    x = x > all(ForwardPeak::deepest) ? all(ForwardPeak::deepest) : x;
    const Lanes place = logarithm(all(1) + x) * all((ForwardPeak::depths - 1) / ForwardPeak::log_of_deepest);
    Lanes from, to;
    Lanes part;
    for (int n = 0; n < 4; ++n) {
        const int j = std::min(int(place[n]), ForwardPeak::depths - 2);
        from[n] = row[j];
        to[n] = row[j + 1];
        part[n] = place[n] - j;
    }
    return (all(1) - part) * from + part * to;
}

/// Fourth order from second, of halves and whole; never of another sign than the halves.
VDBCLOUD_INLINE Lanes extrapolated(Lanes halves, Lanes whole)
{
    const Lanes better = halves + (halves - whole) * all(1.0 / 3);
    return better * halves < all(0) ? halves : better;
}

VDBCLOUD_CLONES void add_beam(const PlainRay& ray, PlainBatch& b, int lit, size_t l)
{
    const auto& depth = b.depth[l];
    const double* row = ray.peak[l];
    Lanes total = all(0);
    for (int i = 0; i < lit; i += 4) {
        const Lanes first = load(b.to_mid + i), whole = load(b.whole + i), second = whole - first,
                    tau = load(b.tau + i);
        const Lanes at_0 = tau + load(&depth[0][size_t(i)]), at_mid = tau + first + load(&depth[1][size_t(i)]),
                    at_1 = tau + whole + load(&depth[2][size_t(i)]);
        const Lanes t_0 = exponential(-at_0), t_mid = exponential(-at_mid), t_1 = exponential(-at_1);
        Lanes before = first * mean_exponential(t_0, t_mid, at_mid - at_0),
              after = second * mean_exponential(t_mid, t_1, at_1 - at_mid),
              across = whole * mean_exponential(t_0, t_1, at_1 - at_0);
        if (row) {
            const Lanes half = all(0.5 * ray.peak_depth_of_tau);
            before *= peak_at(row, half * (at_0 + at_mid));
            after *= peak_at(row, half * (at_mid + at_1));
            across *= peak_at(row, half * (at_0 + at_1));
        }
        total += extrapolated(before + after, across);
    }
    b.direct[l] += sum(total);
}

VDBCLOUD_CLONES void add_collided(const PlainRay& ray, PlainBatch& b, int lit)
{
    Lanes total[3] = {all(0), all(0), all(0)};
    for (int i = 0; i < lit; i += 4) {
        const Lanes first = load(b.to_mid + i), whole = load(b.whole + i), second = whole - first,
                    tau = load(b.tau + i);
        const Lanes t_0 = exponential(-tau), t_mid = exponential(-(tau + first)), t_1 = exponential(-(tau + whole));
        const Lanes half = all(0.5), before = half * first * mean_exponential(t_0, t_mid, first),
                    after = half * second * mean_exponential(t_mid, t_1, second),
                    across = half * whole * mean_exponential(t_0, t_1, whole);
        for (int c = 0; c < ray.channels; ++c) {
            const auto& light = b.collided[c];
            const Lanes l_0 = load(&light[0][size_t(i)]), l_mid = load(&light[1][size_t(i)]),
                        l_1 = load(&light[2][size_t(i)]);
            total[c] += extrapolated((l_0 + l_mid) * before + (l_mid + l_1) * after, (l_0 + l_1) * across);
        }
    }
    for (int c = 0; c < ray.channels; ++c) b.multiple[c] += sum(total[c]);
}

}  // namespace

VDBCLOUD_CLONES void find_depths(const PlainRay& ray, PlainBatch& b)
{
    const int n = (b.count + 3) & ~3;
    for (int i = b.count; i < n; ++i) {  // cells that add nothing
        b.t0[i] = b.t1[i] = 0;
        std::fill_n(b.corner[i], 8, 0.0f);
        for (auto& cell : b.cell) cell[i] = 0;
    }
    for (int i = 0; i < n; i += 4) {
        const Lanes t0 = load(b.t0 + i), length = load(b.t1 + i) - t0;
        Lanes p[3], d[3], v[8];
        for (int a = 0; a < 3; ++a) {
            p[a] = all(ray.origin[a]) + t0 * all(ray.direction[a]) - load(b.cell[a] + i);
            d[a] = length * all(ray.direction[a]);
            store(b.local[a] + i, p[a]);
        }
        transposed(b.corner + i, v);
        // along() of cell_march.h.
        const Lanes bx = v[4] - v[0], by = v[2] - v[0], bz = v[1] - v[0];
        const Lanes ez = v[6] - v[4] - by, ey = v[5] - v[4] - bz, ex = v[3] - v[2] - bz;
        const Lanes h = v[7] - v[6] - v[5] + v[4] - ex;
        const Lanes x = p[0], y = p[1], z = p[2], dx = d[0], dy = d[1], dz = d[2];
        const Lanes yz = ex + h * x, xz = ey + h * y, xy = ez + h * z;
        const Lanes c0 = v[0] + bx * x + y * (by + ez * x) + z * (bz + ey * x + yz * y),
                    c1 = dx * (bx + ez * y + z * xz) + dy * (by + ez * x + z * yz) + dz * (bz + ey * x + y * yz),
                    c2 = dx * dy * xy + dx * dz * xz + dy * dz * yz, c3 = h * dx * dy * dz;
        const Lanes tau = all(ray.sigma_t) * length;
        const Lanes half =
            all(0.5) *
            (c0 + all(0.5) * (c1 * all(1.0 / 2) + all(0.5) * (c2 * all(1.0 / 3) + all(0.5) * (c3 * all(1.0 / 4)))));
        store(b.to_mid + i, tau * half);
        store(b.whole + i, tau * (c0 + (c1 * all(1.0 / 2) + (c2 * all(1.0 / 3) + c3 * all(1.0 / 4)))));
        if (ray.groups == 0) continue;
        for (int k = 0; k < 2; ++k) {
            const double share = k == 0 ? 0.5 : 1;
            const Lanes one = all(1), px = x + dx * all(share), py = y + dy * all(share), pz = z + dz * all(share);
            const Lanes at[4] = {(one - py) * (one - pz), (one - py) * pz, py * (one - pz), py * pz};
            for (int m = 0; m < 4; ++m) {
                store(b.weight[8 * k + m] + i, (one - px) * at[m]);
                store(b.weight[8 * k + 4 + m] + i, px * at[m]);
            }
        }
    }
}

void gather(const PlainRay& ray, PlainBatch& b, int lit)
{
    switch (ray.groups) {
    case 0: break;
    case 1: gather_1(ray, b, lit); break;
    case 2: gather_2(ray, b, lit); break;
    case 3: gather_3(ray, b, lit); break;
    case 4: gather_4(ray, b, lit); break;
    default: gather_any(ray, b, lit);
    }
    for (int i = lit; i < ((lit + 3) & ~3); ++i) {
        b.to_mid[i] = b.whole[i] = b.tau[i] = 0;
        for (int point = 0; point < 3; ++point) {
            for (auto& depth : b.depth) depth[size_t(point)][size_t(i)] = 0;
            for (auto& light : b.collided) light[size_t(point)][size_t(i)] = 0;
        }
    }
}

void add_light(const PlainRay& ray, PlainBatch& b, int lit)
{
    for (size_t l = 0; l < b.direct.size(); ++l) add_beam(ray, b, lit, l);
    if (ray.channels > 0) add_collided(ray, b, lit);
}

}  // namespace vdbcloud
