#pragma once
// Radiance at the end of a characteristic, eight voxels at once: the formula of transport_sweep.h. Private to sweep/.
#include "vdbcloud/sweep/lanes.h"

namespace vdbcloud::lanes {

inline constexpr float series_below = 0.3f;

/// ((1 - e^-t) / t - e^-t) / t by its series, for t below `series_below`.
VDBCLOUD_INLINE Lanes ramp_series(Lanes t)
{
    Lanes s = all(1.0f / 144) - t * all(1.0f / 840);
    s = all(1.0f / 30) - t * s;
    s = all(1.0f / 8) - t * s;
    s = all(1.0f / 3) - t * s;
    return all(0.5f) - t * s;
}

/// (1 - e^-t) / t - e^-t: by its series where that would cancel; `inverse` is 1 / t elsewhere.
VDBCLOUD_INLINE Lanes ramp(Lanes t, Lanes inverse, Lanes lost, Lanes e)
{
    return t < all(series_below) ? t * ramp_series(t) : lost * inverse - e;
}

/// The weight of q_u for emission, without the factor 1 - e^-tau. `whole`: sigma_t ds where the characteristic ends.
VDBCLOUD_INLINE Lanes emission_weight(Lanes sigma_u, Lanes sigma, Lanes whole)
{
    const Lanes e = exp_minus(at_most(whole, 80.0f)), inverse = all(1.0f) / at_least(whole, series_below);
    const Lanes part = whole < all(series_below) ? ramp_series(whole) : ((all(1.0f) - e) * inverse - e) * inverse;
    return all(2.0f) * sigma_u * part / (at_least(sigma_u + sigma, 1e-30f) * (whole * part + e));
}

/// `radiance`, `sigma_u`, `source_u` = sigma_t q where the characteristic begins; `sigma`, `own` = q where it ends;
/// `half`: half its length [world unit]. `emission`: the source is linear in length, not q.
template<bool emission>
VDBCLOUD_INLINE Lanes characteristic(Lanes radiance, Lanes sigma_u, Lanes source_u, Lanes sigma, Lanes own, Lanes half)
{
    const Lanes t = (sigma_u + sigma) * half;
    // 1 / sigma_u, 1 / t and 1 / lean by one division.
    const Lanes divisor = at_least(sigma_u, 1e-30f), length = at_least(t, series_below);
    const Lanes lean = all(6.0f) + t * (all(3.0f) + t), both = divisor * length;
    const Lanes inverse = all(1.0f) / (both * lean), inverse_both = inverse * lean;
    const Lanes q_u = sigma_u > all(0.0f) ? source_u * (inverse_both * length) : own;
    const Lanes q = sigma > all(0.0f) ? own : q_u;
    const Lanes e = exp_minus(at_most(t, 80.0f)), lost = all(1.0f) - e;
    const Lanes weight = emission
                             ? lost * emission_weight(sigma_u, sigma, sigma * half * all(2.0f))
                             : ramp(t, inverse_both * divisor, lost, e) - (sigma - sigma_u) * half * (inverse * both);
    return radiance * e + q * lost + (q_u - q) * weight;
}

}  // namespace vdbcloud::lanes
