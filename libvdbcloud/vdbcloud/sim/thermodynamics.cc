#include "vdbcloud/sim/thermodynamics.h"

#include "vdbcloud/sim/extremes.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace vdbcloud::sim {

namespace {

// Vapour pressure over water, Bolton 1980 eq. 10: 611.2 Pa exp(17.67 (T - 273.15) / (T - 29.65)).
constexpr double e0 = 611.2, slope_a = 17.67, freezing = 273.15, shift_b = 29.65;
// Beyond this range of T [K] the formula has no meaning: T is clamped to it.
constexpr double coldest = 150, hottest = 370;

/// exp without a call, so that loops vectorise and all machines give equal bits; |x| < 80, relative error 2 ulp.
/// x = k ln 2 + r with |r| <= 0.35, then a Taylor polynomial in r.
VDBCLOUD_INLINE float exponential(float x)
{
    const float shifted = x * 1.44269504f + 12582912.0f;  // adding 1.5 * 2^23 rounds to an integer
    const float k = shifted - 12582912.0f;
    const float r = (x - k * 0.693359375f) + k * 2.12194440e-4f;
    float p = 1.0f / 5040;
    p = p * r + 1.0f / 720;
    p = p * r + 1.0f / 120;
    p = p * r + 1.0f / 24;
    p = p * r + 1.0f / 6;
    p = p * r + 0.5f;
    p = p * r * r + r + 1.0f;
    int32_t bits;
    std::memcpy(&bits, &shifted, 4);
    bits = (bits - 0x4b400000 + 127) << 23;
    float power;
    std::memcpy(&power, &bits, 4);
    return p * power;
}

VDBCLOUD_INLINE double exponential(double x)
{
    const double shifted = x * 1.4426950408889634 + 6755399441055744.0;  // 1.5 * 2^52
    const double k = shifted - 6755399441055744.0;
    const double r = (x - k * 6.93145751953125e-1) - k * 1.42860682030941723212e-6;
    double p = 1.0 / 6227020800.0;
    p = p * r + 1.0 / 479001600;
    p = p * r + 1.0 / 39916800;
    p = p * r + 1.0 / 3628800;
    p = p * r + 1.0 / 362880;
    p = p * r + 1.0 / 40320;
    p = p * r + 1.0 / 5040;
    p = p * r + 1.0 / 720;
    p = p * r + 1.0 / 120;
    p = p * r + 1.0 / 24;
    p = p * r + 1.0 / 6;
    p = p * r + 0.5;
    p = p * r * r + r + 1.0;
    int64_t bits;
    std::memcpy(&bits, &shifted, 8);
    bits = (bits - 0x4338000000000000ll + 1023) << 52;
    double power;
    std::memcpy(&power, &bits, 8);
    return p * power;
}

/// q_s and its slope dq_s/dT.
template<typename T>
VDBCLOUD_INLINE T saturated(T temperature, T p, T epsilon, T& slope)
{
    const T t = least(T(hottest), most(T(coldest), temperature));
    const T over = T(1) / (t - T(shift_b));
    const T e = least(T(e0) * exponential(T(slope_a) * (t - T(freezing)) * over), T(0.5) * p);
    const T q = epsilon * e / (p - (T(1) - epsilon) * e);
    slope = q * p / (p - (T(1) - epsilon) * e) * (T(slope_a * (freezing - shift_b)) * over * over);
    return q;
}

/// What the rows need of a level, in their precision.
template<typename T>
struct RowLevel {
    T pressure, exner, q_height, warm, epsilon;
    T theta_ref, q_ref;  // q_height is less this one
    T g;
    T b_theta, b_water, b_cloud, theta_env, q_env, cloud_env;
    bool by_height, moist, hot;
};

/// Solves T = T_l + (L/cp) (q_t - q_s(T)) by Newton's method: q_l = q_t - q_s(T), 0 if there is no cloud. The function
/// is convex and increasing in T, so from the first step on iterates fall towards the root. A few steps
/// suffice for usual air; `remains`, T - T_l - (L/cp) q_l [K], shows where they did not.
template<int steps, typename T>
VDBCLOUD_INLINE T condensate(const RowLevel<T>& c, T theta_l, T q_t, T& remains)
{
    const T t_l = (theta_l + c.theta_ref) * c.exner;
    T t = t_l, slope;
    for (int step = 0; step < steps; ++step) {
        const T q_s = saturated(t, c.pressure, c.epsilon, slope);
        const T excess = (t - t_l) - c.warm * (q_t - q_s);
        t = most(t_l, t - excess / (T(1) + c.warm * slope));
    }
    const T q_l = most(q_t - saturated(t, c.pressure, c.epsilon, slope), T(0));
    remains = (t - t_l) - c.warm * q_l;
    return q_l;
}

/// Cloud water of up to `chunk` cells: 0 if the wettest q_t is below saturation at the coldest theta_l. Else all cells
/// take few steps, and those that have not converged many. No cell's value depends on its neighbours.
constexpr int chunk = 32;
template<typename T>
VDBCLOUD_INLINE void cloud_of_chunk(const RowLevel<T>& c, const T* theta_l, const T* q_t, T* q_l, int n)
{
    if (c.by_height) {
        for (int i = 0; i < n; ++i) q_l[i] = most(q_t[i] - c.q_height, T(0));
        return;
    }
    T cold = theta_l[0], wet = q_t[0], slope;
    if (n == chunk) {
        constexpr int lanes = 8;
        T colds[lanes], wets[lanes];
        for (int l = 0; l < lanes; ++l) colds[l] = theta_l[l], wets[l] = q_t[l];
        for (int i = lanes; i < chunk; i += lanes)
            for (int l = 0; l < lanes; ++l)
                colds[l] = least(colds[l], theta_l[i + l]), wets[l] = most(wets[l], q_t[i + l]);
        for (int l = 0; l < lanes; ++l) cold = least(cold, colds[l]), wet = most(wet, wets[l]);
    } else {
        for (int i = 1; i < n; ++i) cold = least(cold, theta_l[i]), wet = most(wet, q_t[i]);
    }
    // The margin covers rounding of the temperature, so that no saturated cell is skipped.
    if (wet + c.q_ref < T(0.9999) * saturated((cold + c.theta_ref) * c.exner, c.pressure, c.epsilon, slope)) {
        for (int i = 0; i < n; ++i) q_l[i] = T(0);
        return;
    }
    constexpr int few = sizeof(T) == 4 ? 3 : 4;
    constexpr T enough = T(sizeof(T) == 4 ? 1e-4 : 2e-13);
    T remains[chunk];
    for (int i = 0; i < n; ++i) q_l[i] = condensate<few>(c, theta_l[i], q_t[i] + c.q_ref, remains[i]);
    int slow = 0;
    for (int i = 0; i < n; ++i) slow |= !(remains[i] <= enough && remains[i] >= -enough);
    if (slow)
        for (int i = 0; i < n; ++i)
            if (!(remains[i] <= enough && remains[i] >= -enough))
                q_l[i] = condensate<40>(c, theta_l[i], q_t[i] + c.q_ref, remains[i]);
}

template<typename T>
VDBCLOUD_INLINE void cloud_of_row(const RowLevel<T>& c, const T* theta_l, const T* q_t, T* q_l, int n)
{
    for (int i = 0; i < n; i += chunk) cloud_of_chunk(c, theta_l + i, q_t + i, q_l + i, n - i < chunk ? n - i : chunk);
}

template<typename T>
VDBCLOUD_INLINE void buoyancy_of_row(const RowLevel<T>& c, const T* theta_l, const T* q_t, T* out, int n)
{
    if (c.hot) {
        for (int i = 0; i < n; ++i) out[i] = c.g * ((theta_l[i] - c.theta_env) / (theta_l[i] + c.theta_ref));
        return;
    }
    if (!c.moist) {
        for (int i = 0; i < n; ++i) out[i] = c.b_theta * (theta_l[i] - c.theta_env);
        return;
    }
    T q_l[chunk];
    for (int i0 = 0; i0 < n; i0 += chunk) {
        const int m = n - i0 < chunk ? n - i0 : chunk;
        cloud_of_chunk(c, theta_l + i0, q_t + i0, q_l, m);
        for (int i = 0; i < m; ++i)
            out[i0 + i] = c.b_theta * (theta_l[i0 + i] - c.theta_env) + c.b_water * (q_t[i0 + i] - c.q_env) +
                          c.b_cloud * (q_l[i] - c.cloud_env);
    }
}

#define VDBCLOUD_THERMO(T)                                                                                             \
    VDBCLOUD_WIDE_CLONES void cloud_clones(const RowLevel<T>& c, const T* theta_l, const T* q_t, T* q_l, int n)        \
    {                                                                                                                  \
        cloud_of_row(c, theta_l, q_t, q_l, n);                                                                         \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void buoyancy_clones(const RowLevel<T>& c, const T* theta_l, const T* q_t, T* out, int n)     \
    {                                                                                                                  \
        buoyancy_of_row(c, theta_l, q_t, out, n);                                                                      \
    }
VDBCLOUD_THERMO(float)
VDBCLOUD_THERMO(double)
#undef VDBCLOUD_THERMO

template<typename T>
RowLevel<T> row_level(const Constants& k, const MoistTerms& terms, bool moist, const Reference& reference,
                      const Level& level)
{
    RowLevel<T> c;
    c.pressure = T(level.pressure), c.exner = T(level.exner), c.q_height = T(level.q_height - reference.water);
    c.warm = T(terms.latent_heat ? k.latent_heat / k.cp : 0);
    c.epsilon = T(k.r_dry / k.r_vapour);
    c.theta_ref = T(reference.theta), c.q_ref = T(reference.water);
    c.b_theta = T(k.g / k.theta0);
    c.b_water = T(terms.vapour ? 0.608 * k.g : 0);
    c.b_cloud = T((terms.latent_heat ? k.g / k.theta0 * level.heat : 0) - (terms.vapour ? 0.608 * k.g : 0) -
                  (terms.loading ? k.g : 0));
    c.theta_env = T(level.theta_env), c.q_env = T(level.q_env), c.cloud_env = T(0);
    c.by_height = terms.by == SaturationBy::Height;
    c.moist = moist, c.hot = terms.hot;
    c.g = T(k.g);
    return c;
}

}  // namespace

Thermodynamics::Thermodynamics(const Constants& constants, const MoistTerms& terms, bool moisture)
    : Thermodynamics(constants, terms, moisture, {constants.theta0, 0})
{
}

Thermodynamics::Thermodynamics(const Constants& constants, const MoistTerms& terms, bool moisture,
                               const Reference& reference)
    : constants_(constants), terms_(terms), moisture_(moisture), reference_(reference)
{
}

double Thermodynamics::saturation(double temperature, double pressure, double* slope) const
{
    double ignored;
    return saturated(temperature, pressure, constants_.r_dry / constants_.r_vapour, slope ? *slope : ignored);
}

double Thermodynamics::cloud_water(const Level& level, double theta_l, double q_t) const
{
    double q_l = 0;
    cloud_row<double>(level, &theta_l, &q_t, &q_l, 1);
    return q_l;
}

double Thermodynamics::buoyancy(const Level& level, double theta_l, double q_t) const
{
    double b = 0;
    buoyancy_row<double>(level, &theta_l, &q_t, nullptr, &b, 1);
    return b;
}

template<typename T>
void Thermodynamics::cloud_row(const Level& level, const T* theta_l, const T* q_t, T* q_l, int n) const
{
    cloud_clones(row_level<T>(constants_, terms_, moisture_, reference_, level), theta_l, q_t, q_l, n);
}

template<typename T>
void Thermodynamics::buoyancy_row(const Level& level, const T* theta_l, const T* q_t, const T* carried, T* out,
                                  int n) const
{
    RowLevel<T> c = row_level<T>(constants_, terms_, moisture_, reference_, level);
    // The environment's cloud by the arithmetic of the cells: air like the environment's has a buoyancy of exactly 0.
    if (moisture_) cloud_of_row(c, &c.theta_env, &c.q_env, &c.cloud_env, 1);
    buoyancy_clones(c, theta_l, q_t, out, n);
    if (!carried) return;
    const T g = T(constants_.g);
    for (int i = 0; i < n; ++i) out[i] -= g * carried[i];
}

template void Thermodynamics::cloud_row(const Level&, const float*, const float*, float*, int) const;
template void Thermodynamics::cloud_row(const Level&, const double*, const double*, double*, int) const;
template void Thermodynamics::buoyancy_row(const Level&, const float*, const float*, const float*, float*, int) const;
template void Thermodynamics::buoyancy_row(const Level&, const double*, const double*, const double*, double*,
                                           int) const;

}  // namespace vdbcloud::sim
