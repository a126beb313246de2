// The planes of one block for one direction: the innermost loop of a sweep.
#include "vdbcloud/core/clones.h"
#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/sweep/characteristic.h"

#include <cstring>
#include <utility>

namespace vdbcloud::block_sweep {

using namespace lanes;

namespace {

/// A row and the value upstream of it, interpolated along the row.
template<int sign_v>
VDBCLOUD_INLINE Lanes along_row(const float* row, const float* upstream, Lanes own, Lanes up)
{
    const Lanes x = load(row), beside = all(*upstream);
    const Lanes shifted = sign_v > 0 ? __builtin_shufflevector(x, beside, 8, 0, 1, 2, 3, 4, 5, 6)
                                     : __builtin_shufflevector(x, beside, 1, 2, 3, 4, 5, 6, 7, 8);
    return own * x + up * shifted;
}

/// The rows of the plane before a plane, and the row upstream of them.
struct PlaneBefore {
    PlaneBefore() = default;
    PlaneBefore(const Apron& apron, const float* inside, int up, int plane, int row_pitch)
    {
        if (up < 0 || up > 7)
            *this = {apron.region[0], 8, apron.region[4], apron.region[3], apron.region[6]};
        else
            *this = {inside + up * plane, row_pitch, apron.region[2] + up * 8, apron.region[1] + up * 8,
                     apron.region[5] + up * apron.pitch};
    }
    PlaneBefore(const float* first, int of_rows, const float* values_beside, const float* row, const float* value)
        : rows(first), pitch(of_rows), beside(values_beside), row_up(row), corner(value)
    {
    }
    const float* rows;
    int pitch;
    const float *beside, *row_up, *corner;
};

/// Calls f(c) for each channel, c a constant: what it keeps in arrays by channel then stays in registers.
template<size_t... c, typename F>
VDBCLOUD_INLINE void each(std::index_sequence<c...>, const F& f)
{
    (f(std::integral_constant<size_t, c>{}), ...);
}

#define VDBCLOUD_EACH_CHANNEL(...)                                                                                     \
    each(std::make_index_sequence<channels>{}, [&](auto c) __attribute__((always_inline)) __VA_ARGS__)

template<bool emission, int channels, int sign_v, bool all_lit, bool walls>
VDBCLOUD_INLINE void sweep_inside(const Traversal& traversal, int d, float* const* radiance, Scratch* s,
                                  DownstreamFaces* to)
{
    constexpr int last_v = sign_v > 0 ? 7 : 0;
    const int plane = traversal.row_stride[0], row = traversal.row_stride[1];
    const Lanes u_own = all(1 - traversal.u_up), u_up = all(traversal.u_up), v_own = all(1 - traversal.v_up),
                v_up = all(traversal.v_up), half = all(traversal.half_step);
    const auto row_before = [&](const PlaneBefore& from) __attribute__((always_inline))
    {
        return along_row<sign_v>(from.row_up, from.corner, v_own, v_up);
    };
    const auto row_of = [&](const PlaneBefore& from, int r) __attribute__((always_inline))
    {
        return along_row<sign_v>(from.rows + r * from.pitch, from.beside + r, v_own, v_up);
    };
    for (int k = 0; k < 8; ++k) {
        const int p = traversal.sign[0] > 0 ? k : 7 - k, up = p - traversal.sign[0];
        const PlaneBefore extinction(s->sigma_before, s->sigma, up, plane, row);
        PlaneBefore light[channels], emitted[channels];
        Lanes last_light[channels], last_sigma = row_before(extinction), last_source[channels];
        VDBCLOUD_EACH_CHANNEL({
            light[c] = PlaneBefore(s[c].radiance_before, radiance[c], up, plane, row);
            emitted[c] = PlaneBefore(s[c].source_before, s[c].source, up, plane, row);
            last_light[c] = row_before(light[c]);
            last_source[c] = row_before(emitted[c]);
        });
        const unsigned lit = s->lit[size_t(p)], next_lit = traversal.sign[1] > 0 ? lit >> 1 : lit << 1;
        for (int n = 0; n < 8; ++n) {
            const int r = traversal.sign[1] > 0 ? n : 7 - n, here = p * plane + r * row;
            const auto leave = [&](size_t c, Lanes value, const Lanes& source) __attribute__((always_inline))
            {
                if (walls) {
                    const Lanes wall = load(s[c].wall + here);
                    value = wall == wall ? wall : value;
                }
                store(radiance[c] + here, value);
                store(s[c].source + here, source);
                to[c].radiance[2][size_t(p * 8 + r)] = value[last_v];
                to[c].source[2][size_t(p * 8 + r)] = source[last_v];
                if (n == 7) {
                    store(to[c].radiance[1].data() + p * 8, value);
                    store(to[c].source[1].data() + p * 8, source);
                }
                if (k == 7) {
                    store(to[c].radiance[0].data() + r * 8, value);
                    store(to[c].source[0].data() + r * 8, source);
                }
            };
            const auto light_before = [&](size_t c) __attribute__((always_inline))
            {
                const Lanes own = row_of(light[c], r), value = u_own * own + u_up * last_light[c];
                last_light[c] = own;
                return value;
            };
            if (!(all_lit || ((lit | next_lit) >> r & 1))) {
                VDBCLOUD_EACH_CHANNEL({ leave(c, light_before(c), all(0.0f)); });
                continue;
            }
            const Lanes this_sigma = row_of(extinction, r);
            if (!(all_lit || (lit >> r & 1))) {
                VDBCLOUD_EACH_CHANNEL({
                    last_source[c] = row_of(emitted[c], r);
                    leave(c, light_before(c), all(0.0f));
                });
                last_sigma = this_sigma;
                continue;
            }
            const Lanes sigma = load(s->sigma + here);
            const Passage<emission> passage(u_own * this_sigma + u_up * last_sigma, sigma, half);
            last_sigma = this_sigma;
            VDBCLOUD_EACH_CHANNEL({
                const Lanes this_source = row_of(emitted[c], r), source_u = u_own * this_source + u_up * last_source[c];
                last_source[c] = this_source;
                const Lanes own = load(s[c].q[d] + here), source = sigma * own;
                leave(c, passage(light_before(c), source_u, own, source), source);
            });
        }
    }
}

#undef VDBCLOUD_EACH_CHANNEL

template<bool emission, int channels, int sign_v>
VDBCLOUD_INLINE void sweep_inside(const Traversal& traversal, int d, float* const* radiance, Scratch* s,
                                  DownstreamFaces* to)
{
    uint64_t lit;
    std::memcpy(&lit, s->lit.data(), sizeof lit);
    if (s->wall)
        sweep_inside<emission, channels, sign_v, false, true>(traversal, d, radiance, s, to);
    else if (!~lit)
        sweep_inside<emission, channels, sign_v, true, false>(traversal, d, radiance, s, to);
    else
        sweep_inside<emission, channels, sign_v, false, false>(traversal, d, radiance, s, to);
}

template<int channels>
VDBCLOUD_INLINE void sweep_channels(const Traversal& traversal, int d, bool emission, Scratch* s, DownstreamFaces* to)
{
    const bool is_turned = traversal.layout == &turned;
    float* radiance[channels];
    for (int c = 0; c < channels; ++c) radiance[c] = is_turned ? s[c].turned : s[c].out[d];
    if (emission)
        traversal.sign[2] > 0 ? sweep_inside<true, channels, 1>(traversal, d, radiance, s, to)
                              : sweep_inside<true, channels, -1>(traversal, d, radiance, s, to);
    else
        traversal.sign[2] > 0 ? sweep_inside<false, channels, 1>(traversal, d, radiance, s, to)
                              : sweep_inside<false, channels, -1>(traversal, d, radiance, s, to);
    for (int c = 0; c < channels; ++c) {
        if (is_turned)
            for (int x = 0; x < 8; ++x) transpose(radiance[c] + x * 8, 64, s[c].out[d] + x * 64, 8);
        s[c].radiance = radiance[c];
    }
}

VDBCLOUD_CLONES void sweep_one(const Traversal& traversal, int d, bool emission, Scratch* s, DownstreamFaces* to)
{
    sweep_channels<1>(traversal, d, emission, s, to);
}
VDBCLOUD_CLONES void sweep_two(const Traversal& traversal, int d, bool emission, Scratch* s, DownstreamFaces* to)
{
    sweep_channels<2>(traversal, d, emission, s, to);
}
VDBCLOUD_CLONES void sweep_three(const Traversal& traversal, int d, bool emission, Scratch* s, DownstreamFaces* to)
{
    sweep_channels<3>(traversal, d, emission, s, to);
}

}  // namespace

void sweep_planes(const Traversal& traversal, int d, bool emission, int channels, Scratch* s, DownstreamFaces* to)
{
    static_assert(most_channels == 3);
    if (channels == 1) return sweep_one(traversal, d, emission, s, to);
    if (channels == 2) return sweep_two(traversal, d, emission, s, to);
    sweep_three(traversal, d, emission, s, to);
}

}  // namespace vdbcloud::block_sweep
