#include "vdbcloud/sweep/lattice_frame.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

int ifloor(double x) { return int(std::floor(x)); }

/// Along index axis w; `s`: the direction of travel in index space.
LatticeFrame frame_along(int w, const Vec3d& s)
{
    LatticeFrame f{};
    f.w = w;
    // Rows of a plane buffer run along z, which is contiguous in a brick, where that is possible.
    f.u = f.w == 2 ? 1 : 2;
    f.v = 3 - f.u - f.w;
    f.sign = s[f.w] > 0 ? 1 : -1;
    f.length = 1 / std::abs(s[f.w]);
    f.mu = s[f.u] * f.length;
    f.mv = s[f.v] * f.length;
    return f;
}

constexpr double tie = 1e-7;        // relative: axes along which light is as fast but for rounding
constexpr double same_stop = 1e-9;  // voxels: offsets that differ by rounding alone

/// Where a step crosses walls of cells, rising, with its ends.
struct Cuts {
    int count = 1;
    std::array<double, 12> at{0};

    void cross(double start, double slope, double step)
    {
        if (slope == 0) return;
        const double end = start + slope * step;
        const int lo = ifloor(std::min(start, end)), hi = ifloor(std::max(start, end)) + 1;
        for (int wall = lo; wall <= hi; ++wall)
            if (const double s = (wall - start) / slope; s > 0 && s < step) insert(s);
    }
    void insert(double s)
    {
        int n = count++;
        for (; n > 0 && at[size_t(n - 1)] > s; --n) at[size_t(n)] = at[size_t(n - 1)];
        at[size_t(n)] = s;
    }
};

}  // namespace

std::vector<LatticeFrame> frames_of(const BrickMap& density, const Vec3d& to_light)
{
    const Vec3d s = density.index_from_world().vector(-to_light);
    const double fastest = std::max({std::abs(s[0]), std::abs(s[1]), std::abs(s[2])});
    std::vector<LatticeFrame> frames;
    for (int a = 0; a < 3; ++a)
        if (std::abs(s[a]) >= (1 - tie) * fastest) frames.push_back(frame_along(a, s));
    return frames;
}

LatticeOffset::LatticeOffset(const LatticeFrame& f, const Vec3d& offset)
    : u(offset[f.u]), v(offset[f.v]), shift(ifloor(f.sign * offset[f.w])), fraction(f.sign * offset[f.w] - shift)
{
    if (fraction < same_stop) fraction = 0;
    if (fraction > 1 - same_stop) {
        ++shift;
        fraction = 0;
    }
}

std::vector<double> stops_of(const std::vector<LatticeOffset>& offsets)
{
    std::vector<double> stops;
    for (const LatticeOffset& offset : offsets) stops.push_back(offset.fraction);
    std::sort(stops.begin(), stops.end());
    stops.erase(std::unique(stops.begin(), stops.end(), [](double a, double b) { return b - a < same_stop; }),
                stops.end());
    return stops;
}

size_t stop_of(const std::vector<double>& stops, const LatticeOffset& offset)
{
    return size_t(std::upper_bound(stops.begin(), stops.end(), offset.fraction) - stops.begin()) - 1;
}

LatticeTaps step_taps(const LatticeFrame& f, double u0, double v0, double w0, double step)
{
    Cuts cuts;
    cuts.cross(u0, f.mu, step);
    cuts.cross(v0, f.mv, step);
    cuts.cross(w0, 1, step);
    cuts.insert(step);

    // Weights of the voxels about the step. |mu|, |mv| <= 1 but for rounding, so it meets three cells along an axis at
    // most.
    constexpr int side = 4;
    double weight[side][side][side] = {};  // [w][v][u]
    const int first_u = ifloor(std::min(u0, u0 + f.mu * step)), first_v = ifloor(std::min(v0, v0 + f.mv * step)),
              first_w = ifloor(w0);
    for (int n = 0; n + 1 < cuts.count; ++n) {
        const double a = cuts.at[size_t(n)], b = cuts.at[size_t(n + 1)], mid = (a + b) / 2;
        if (b - a < 1e-14) continue;
        const int iu = ifloor(u0 + mid * f.mu), iv = ifloor(v0 + mid * f.mv), iw = ifloor(w0 + mid);
        for (const double x : {-0.57735026918962576, 0.57735026918962576}) {
            const double s = mid + x * (b - a) / 2, half = (b - a) / 2 * f.length;
            const double pu = u0 + s * f.mu - iu, pv = v0 + s * f.mv - iv, pw = w0 + s - iw;
            for (int c = 0; c < 8; ++c)
                weight[iw - first_w + (c >> 2)][iv - first_v + ((c >> 1) & 1)][iu - first_u + (c & 1)] +=
                    half * (c & 1 ? pu : 1 - pu) * (c & 2 ? pv : 1 - pv) * (c & 4 ? pw : 1 - pw);
        }
    }
    LatticeTaps taps;
    for (int w = 0; w < side; ++w)
        for (int v = 0; v < side; ++v)
            for (int u = 0; u < side; ++u)
                if (weight[w][v][u] != 0)
                    taps.tap[size_t(taps.count++)] = {first_u + u, first_v + v, first_w + w, weight[w][v][u]};
    return taps;
}

double mean_taps(const LatticeFrame& f, const std::vector<double>& stops, int rays_per_voxel)
{
    int taps = 0;
    constexpr int places = 16;
    for (int n = 0; n < places; ++n)
        for (size_t stop = 0; stop < stops.size(); ++stop)
            for (int q = 0; q < rays_per_voxel; ++q)
                for (int p = 0; p < rays_per_voxel; ++p) {
                    const LatticeStep step(stops, stop);
                    const double w0 = n + step.from;
                    taps += step_taps(f, double(p) / rays_per_voxel + f.mu * w0, double(q) / rays_per_voxel + f.mv * w0,
                                      w0, step.length)
                                .count;
                }
    return double(taps) / (places * rays_per_voxel * rays_per_voxel);
}

}  // namespace vdbcloud
