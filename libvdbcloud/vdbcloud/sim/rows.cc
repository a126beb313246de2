#include "vdbcloud/sim/rows.h"

#include "vdbcloud/sim/extremes.h"

#include <limits>

namespace vdbcloud::sim {

namespace {

/// The argument of least magnitude if all have one sign, else 0.
template<typename T>
VDBCLOUD_INLINE T minmod(T a, T b, T c)
{
    return most(T(0), least(a, least(b, c))) + least(T(0), most(a, most(b, c)));
}

template<MomentumScheme scheme, typename T>
VDBCLOUD_INLINE void momentum_flux_row(const MomentumFlux<T>& f, T* __restrict out, int n)
{
    const T* __restrict a = f.a;
    const T* __restrict b = f.b;
    const T* q = f.q;
    const ptrdiff_t s = f.s;
    const T wa = f.wa, wb = f.wb;
    for (int i = 0; i < n; ++i) {
        const T v = wa * a[i] + wb * b[i];
        const T m1 = q[i - s], p0 = q[i];
        if constexpr (scheme == MomentumScheme::Upwind) {
            out[i] = v * (v > T(0) ? m1 : p0);
        } else {
            const T m3 = q[i - 3 * s], m2 = q[i - 2 * s], p1 = q[i + s], p2 = q[i + 2 * s];
            const T even = T(37.0 / 60) * (p0 + m1) - T(8.0 / 60) * (p1 + m2) + T(1.0 / 60) * (p2 + m3);
            const T odd = T(10.0 / 60) * (p0 - m1) - T(5.0 / 60) * (p1 - m2) + T(1.0 / 60) * (p2 - m3);
            out[i] = v * even - magnitude(v) * odd;
        }
    }
}

template<ScalarScheme scheme, typename T>
VDBCLOUD_INLINE void scalar_flux_row(const ScalarFlux<T>& f, T* __restrict out, int n)
{
    const T* __restrict v = f.v;
    const T* q = f.q;
    const T* drain = f.drain;
    const T inv_tau = f.inv_tau;
    const ptrdiff_t s = f.s;
    for (int i = 0; i < n; ++i) {
        // Both sides are loaded before one is chosen: a choice between values vectorises, one between loads does not.
        const bool up = v[i] > T(0);
        const T m1 = q[i - s], p0 = q[i];
        const T d = up ? m1 : p0;
        T delta = T(0);
        if constexpr (scheme != ScalarScheme::Upwind) {
            const T m2 = q[i - 2 * s], p1 = q[i + s];
            const T across = p0 - m1, lower = m1 - m2, upper = p0 - p1;
            const T ahead = up ? across : -across, behind = up ? lower : upper;
            if constexpr (scheme == ScalarScheme::Koren) {
                delta = T(1.0 / 3) * ahead + T(1.0 / 6) * behind;
            } else {
                const T m3 = q[i - 3 * s], p2 = q[i + 2 * s];
                const T far_lower = m2 - m3, far_upper = p1 - p2;
                const T far_ahead = up ? -upper : -lower, far_behind = up ? far_lower : far_upper;
                delta =
                    T(24.0 / 60) * ahead + T(11.0 / 60) * behind - T(3.0 / 60) * far_ahead - T(2.0 / 60) * far_behind;
            }
            if constexpr (scheme != ScalarScheme::Plain5) {
                const T drain_lower = drain[i - s], drain_upper = drain[i];
                const T room = (up ? drain_lower : drain_upper) * inv_tau - T(1);
                const T m = most(T(0), least(T(4), room));
                delta = minmod(delta, ahead, m * behind);
            }
        }
        out[i] = v[i] * (d + delta);
    }
}

template<typename T>
VDBCLOUD_INLINE void flux_tendency_row(const FluxRows<T>& f, T* __restrict out, int n)
{
    if (f.z0) {
        for (int i = 0; i < n; ++i) out[i] = f.cz0 * f.z0[i] - f.cz1 * f.z1[i];
    } else {
        for (int i = 0; i < n; ++i) out[i] = T(0);
    }
    if (f.x)
        for (int i = 0; i < n; ++i) out[i] -= f.cx * (f.x[i + 1] - f.x[i]);
    if (f.y0)
        for (int i = 0; i < n; ++i) out[i] -= f.cy * (f.y1[i] - f.y0[i]);
}

template<typename T>
VDBCLOUD_INLINE void scalar_stage_row(const StageRows<T>& r, const ScalarStage& s, int n)
{
    const T alpha = T(s.alpha), beta = T(s.beta), tau = T(s.tau), least = T(s.least), tiny = T(s.tiny);
    constexpr T ulps = T(4) * std::numeric_limits<T>::epsilon();
    for (int i = 0; i < n; ++i) {
        const T x0 = r.x0[i];
        const T next = x0 + (alpha * (r.x1[i] - x0) + beta * ((r.x[i] - x0) + tau * r.tendency[i]));
        const T raised = most(next, least), low = least - most(tiny, ulps * (x0 - least));
        r.out[i] = next > low ? (tiny > T(0) ? raised : next) : next;
    }
}

template<typename T>
VDBCLOUD_INLINE void momentum_stage_row(const StageRows<T>& r, const MomentumStage& s, int n)
{
    const T a0 = T(s.a0), a1 = T(s.a1), ax = T(s.ax), al = T(s.al), constant = T(s.constant);
    for (int i = 0; i < n; ++i)
        r.out[i] = ((a0 * r.x0[i] + a1 * r.x1[i]) + (ax * r.x[i] + al * r.tendency[i])) + constant;
}

template<typename T>
VDBCLOUD_INLINE void courant_row(const CourantRows<T>& c, T* __restrict drain, double& rate, int n)
{
    constexpr int lanes = 16, longest = 4096;
    T fast[longest];
    for (int i = 0; i < n; ++i) drain[i] = fast[i] = T(0);
    const auto add = [&](const T* lower, const T* upper, T c0, T c1) __attribute__((always_inline))
    {
        for (int i = 0; i < n; ++i) {
            const T a = magnitude(lower[i]) * c0, b = magnitude(upper[i]) * c1;
            drain[i] += T(0.5) * (a + b);
            fast[i] += most(a, b);
        }
    };
    if (c.u) add(c.u, c.u + 1, c.cx, c.cx);
    if (c.v0) add(c.v0, c.v1, c.cy, c.cy);
    if (c.w0) add(c.w0, c.w1, c.cz0, c.cz1);
    T top[lanes] = {}, poison[lanes] = {};
    int i0 = 0;
    for (; i0 + lanes <= n; i0 += lanes)
        for (int l = 0; l < lanes; ++l) {
            top[l] = most(fast[i0 + l], top[l]);
            poison[l] += T(0) * drain[i0 + l];
        }
    for (int l = 0; i0 + l < n; ++l) {
        top[l] = most(fast[i0 + l], top[l]);
        poison[l] += T(0) * drain[i0 + l];
    }
    for (int half = lanes / 2; half > 0; half /= 2)
        for (int l = 0; l < half; ++l) top[l] = most(top[l], top[l + half]), poison[l] += poison[l + half];
    for (int i = 0; i < n; ++i) drain[i] = T(1) / most(drain[i], T(1e-30));
    if (double(top[0]) > rate) rate = double(top[0]);
    if (!(poison[0] == T(0))) rate = double(poison[0]);
}

template<typename T>
VDBCLOUD_INLINE void add_sum_row(T* out, const T* a, const T* b, T c, int n)
{
    for (int i = 0; i < n; ++i) out[i] += c * (a[i] + b[i]);
}

template<typename T>
VDBCLOUD_INLINE void add_laplacian_row(const LaplaceRow<T>& r, T* __restrict out, int n)
{
    const T* q = r.q;
    for (int i = 0; i < n; ++i) {
        const T twice = q[i] + q[i];
        out[i] += r.cx * ((q[i - r.sx] + q[i + r.sx]) - twice) + r.cy * ((q[i - r.sy] + q[i + r.sy]) - twice) +
                  r.cz * ((q[i - r.sz] + q[i + r.sz]) - twice);
    }
}

template<typename T>
VDBCLOUD_INLINE void add_relaxation_row(T* out, const T* q, T target, T rate, int n)
{
    for (int i = 0; i < n; ++i) out[i] -= rate * (q[i] - target);
}

template<typename T>
VDBCLOUD_INLINE void momentum_flux_any(MomentumScheme scheme, const MomentumFlux<T>& f, T* out, int n)
{
    scheme == MomentumScheme::Upwind ? momentum_flux_row<MomentumScheme::Upwind>(f, out, n)
                                     : momentum_flux_row<MomentumScheme::Upwind5>(f, out, n);
}

template<typename T>
VDBCLOUD_INLINE void scalar_flux_any(ScalarScheme scheme, const ScalarFlux<T>& f, T* out, int n)
{
    switch (scheme) {
    case ScalarScheme::Upwind: return scalar_flux_row<ScalarScheme::Upwind>(f, out, n);
    case ScalarScheme::Koren: return scalar_flux_row<ScalarScheme::Koren>(f, out, n);
    case ScalarScheme::Limited5: return scalar_flux_row<ScalarScheme::Limited5>(f, out, n);
    case ScalarScheme::Plain5: return scalar_flux_row<ScalarScheme::Plain5>(f, out, n);
    }
}

}  // namespace

#define VDBCLOUD_ROWS(T)                                                                                               \
    VDBCLOUD_WIDE_CLONES void momentum_flux(MomentumScheme m, const MomentumFlux<T>& f, T* out, int n)                 \
    {                                                                                                                  \
        momentum_flux_any(m, f, out, n);                                                                               \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void scalar_flux(ScalarScheme m, const ScalarFlux<T>& f, T* out, int n)                       \
    {                                                                                                                  \
        scalar_flux_any(m, f, out, n);                                                                                 \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void flux_tendency(const FluxRows<T>& f, T* out, int n) { flux_tendency_row(f, out, n); }     \
    VDBCLOUD_WIDE_CLONES void scalar_stage(const StageRows<T>& r, const ScalarStage& s, int n)                         \
    {                                                                                                                  \
        scalar_stage_row(r, s, n);                                                                                     \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void momentum_stage(const StageRows<T>& r, const MomentumStage& s, int n)                     \
    {                                                                                                                  \
        momentum_stage_row(r, s, n);                                                                                   \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void courant(const CourantRows<T>& c, T* drain, double& rate, int n)                          \
    {                                                                                                                  \
        courant_row(c, drain, rate, n);                                                                                \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void add_sum(T* out, const T* a, const T* b, T c, int n) { add_sum_row(out, a, b, c, n); }    \
    VDBCLOUD_WIDE_CLONES void add_laplacian(const LaplaceRow<T>& r, T* out, int n) { add_laplacian_row(r, out, n); }   \
    VDBCLOUD_WIDE_CLONES void add_relaxation(T* out, const T* q, T target, T rate, int n)                              \
    {                                                                                                                  \
        add_relaxation_row(out, q, target, rate, n);                                                                   \
    }
VDBCLOUD_ROWS(float)
VDBCLOUD_ROWS(double)
#undef VDBCLOUD_ROWS

}  // namespace vdbcloud::sim
