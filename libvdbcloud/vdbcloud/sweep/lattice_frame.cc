#include "vdbcloud/sweep/lattice_frame.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

int ifloor(double x) { return int(std::floor(x)); }

/// Along index axis w; `s`: the direction of travel in index space.
LatticeFrame frame_along(int w, const Vec3d& s, const Vec3d& offset)
{
    LatticeFrame f{};
    f.w = w;
    f.u =
        f.w == 2 ? 1 : 2;  // rows of a plane buffer run along z, which is contiguous in a brick, where that is possible
    f.v = 3 - f.u - f.w;
    f.sign = s[f.w] > 0 ? 1 : -1;
    f.length = 1 / std::abs(s[f.w]);
    f.mu = s[f.u] * f.length;
    f.mv = s[f.v] * f.length;
    f.ou = offset[f.u];
    f.ov = offset[f.v];
    f.ow = f.sign * offset[f.w];
    return f;
}

constexpr double tie = 1e-7;  // relative: axes along which light is as fast but for rounding

}  // namespace

std::vector<LatticeFrame> frames_of(const BrickMap& density, const Vec3d& to_light, const Vec3d& offset)
{
    const Vec3d s = density.index_from_world().vector(-to_light);
    const double fastest = std::max({std::abs(s[0]), std::abs(s[1]), std::abs(s[2])});
    std::vector<LatticeFrame> frames;
    for (int a = 0; a < 3; ++a)
        if (std::abs(s[a]) >= (1 - tie) * fastest) frames.push_back(frame_along(a, s, offset));
    return frames;
}

std::vector<LatticeTap> step_taps(const LatticeFrame& f, double u0, double v0, double w0)
{
    std::vector<double> cuts{0, 1};
    const auto cut = [&](double start, double slope) {
        if (slope == 0) return;
        const int lo = ifloor(std::min(start, start + slope)), hi = ifloor(std::max(start, start + slope)) + 1;
        for (int wall = lo; wall <= hi; ++wall)
            if (const double s = (wall - start) / slope; s > 0 && s < 1) cuts.push_back(s);
    };
    cut(u0, f.mu);
    cut(v0, f.mv);
    cut(w0, 1);
    std::sort(cuts.begin(), cuts.end());

    std::vector<LatticeTap> taps;
    const auto add = [&](int du, int dv, int dw, double weight) {
        if (weight == 0) return;
        for (auto& t : taps)
            if (t.du == du && t.dv == dv && t.dw == dw) {
                t.weight += weight;
                return;
            }
        taps.push_back({du, dv, dw, weight});
    };
    for (size_t n = 0; n + 1 < cuts.size(); ++n) {
        const double a = cuts[n], b = cuts[n + 1], mid = (a + b) / 2;
        if (b - a < 1e-14) continue;
        const int iu = ifloor(u0 + mid * f.mu), iv = ifloor(v0 + mid * f.mv), iw = ifloor(w0 + mid);
        for (const double x : {-0.57735026918962576, 0.57735026918962576}) {
            const double s = mid + x * (b - a) / 2, half = (b - a) / 2 * f.length;
            const double pu = u0 + s * f.mu - iu, pv = v0 + s * f.mv - iv, pw = w0 + s - iw;
            for (int c = 0; c < 8; ++c)
                add(iu + (c & 1), iv + ((c >> 1) & 1), iw + (c >> 2),
                    half * (c & 1 ? pu : 1 - pu) * (c & 2 ? pv : 1 - pv) * (c & 4 ? pw : 1 - pw));
        }
    }
    return taps;
}

double mean_taps(const LatticeFrame& f, int rays_per_voxel)
{
    size_t taps = 0;
    constexpr int places = 16;
    for (int n = 0; n < places; ++n)
        for (int q = 0; q < rays_per_voxel; ++q)
            for (int p = 0; p < rays_per_voxel; ++p) {
                const double w0 = n + f.ow;
                taps += step_taps(f, double(p) / rays_per_voxel + f.mu * w0, double(q) / rays_per_voxel + f.mv * w0, w0)
                            .size();
            }
    return double(taps) / (places * rays_per_voxel * rays_per_voxel);
}

}  // namespace vdbcloud
