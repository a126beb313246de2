#include "vdbcloud/sweep/plane_kernel.h"

#include "vdbcloud/sweep/block_walk.h"
#include "vdbcloud/sweep/characteristic.h"

#include <cmath>

namespace vdbcloud::plane_kernel {

using namespace lanes;

namespace {

VDBCLOUD_INLINE Lanes take(const float* from, bool contiguous)
{
    if (contiguous) return load(from);
    return Lanes{from[0], from[8], from[16], from[24], from[32], from[40], from[48], from[56]};
}

VDBCLOUD_INLINE void put(float* to, Lanes value, bool contiguous)
{
    if (contiguous) return store(to, value);
    for (int i = 0; i < 8; ++i) to[8 * i] = value[i];
}

}  // namespace

Offset::Offset(const Vec3d& step, int w, int along_u, int along_v, int nu, int nv)
{
    const double ds = 1 / std::abs(step[w]);
    const double pu = snapped(-step[along_u] * ds), pv = snapped(-step[along_v] * ds);
    const double iu = std::floor(pu), iv = std::floor(pv), fu = pu - iu, fv = pv - iv;
    u = int(std::fmod(iu, nu));
    v = int(std::fmod(iv, nv));
    u += u < 0 ? nu : 0;
    v += v < 0 ? nv : 0;
    c00 = float((1 - fu) * (1 - fv));
    c01 = float((1 - fu) * fv);
    c10 = float(fu * (1 - fv));
    c11 = float(fu * fv);
    half_step = float(ds / 2);
}

VDBCLOUD_CLONES void sweep_row(const Job& job, int row, const int32_t* blocks, int tiles, size_t in_block)
{
    const size_t pitch = pitch_of(job.columns), repeat = size_t(job.columns);
    const int sources = int(job.source.size()), terms = int(job.moments.size());
    const bool contiguous = job.contiguous;
    for (int tile = 0; tile < tiles; ++tile) {
        const size_t to = size_t(row) * pitch + size_t(8 * tile);
        const auto keep = [&](float* at, Lanes value) {
            store(at, value);
            if (tile == 0) store(at + repeat, value);
        };
        if (blocks[tile] < 0) {
            keep(job.sigma_here + to, all(0.0f));
            for (int d = 0; d < job.directions; ++d) keep(job.here[size_t(d)].source + to, all(0.0f));
            continue;
        }
        const size_t slot = size_t(blocks[tile]) * 512 + in_block;
        const Lanes sigma = take(job.sigma + slot, contiguous);
        keep(job.sigma_here + to, sigma);
        Lanes own[batch], out[batch];
        for (int d = 0; d < batch; ++d) own[d] = all(0.0f);
        for (int k = 0; k < sources; ++k) {
            const Lanes term = take(job.source[size_t(k)] + slot, contiguous);
            for (int d = 0; d < batch; ++d) own[d] += all(job.basis[k * batch + d]) * term;
        }
        for (int d = 0; d < job.directions; ++d) {
            const Offset& o = job.offsets[d];
            const int first = row + o.u < job.rows ? row + o.u : row + o.u - job.rows,
                      second = first + 1 < job.rows ? first + 1 : 0;
            const int column = 8 * tile + o.v < job.columns ? 8 * tile + o.v : 8 * tile + o.v - job.columns;
            const size_t p = size_t(first) * pitch + size_t(column), q = size_t(second) * pitch + size_t(column);
            const auto before = [&](const float* f) {
                return (all(o.c00) * load(f + p) + all(o.c01) * load(f + p + 1)) +
                       (all(o.c10) * load(f + q) + all(o.c11) * load(f + q + 1));
            };
            const Lanes radiance = before(job.before[size_t(d)].radiance), sigma_u = before(job.sigma_before);
            out[d] = radiance;
            if (any(sigma) || any(sigma_u)) {
                const Lanes source_u = before(job.before[size_t(d)].source), half = all(o.half_step);
                out[d] = job.emission ? characteristic<true>(radiance, sigma_u, source_u, sigma, own[d], half)
                                      : characteristic<false>(radiance, sigma_u, source_u, sigma, own[d], half);
            }
            const Plane& here = job.here[size_t(d)];
            keep(here.radiance + to, out[d]);
            keep(here.source + to, sigma * own[d]);
        }
        for (int d = job.directions; d < batch; ++d) out[d] = all(0.0f);
        for (int k = 0; k < terms; ++k) {
            const float* w = job.weight + k * batch;
            const Lanes low = (all(w[0]) * out[0] + all(w[1]) * out[1]) + (all(w[2]) * out[2] + all(w[3]) * out[3]);
            const Lanes high = (all(w[4]) * out[4] + all(w[5]) * out[5]) + (all(w[6]) * out[6] + all(w[7]) * out[7]);
            float* moment = job.moments[size_t(k)] + slot;
            put(moment, take(moment, contiguous) + (low + high), contiguous);
        }
    }
}

}  // namespace vdbcloud::plane_kernel
