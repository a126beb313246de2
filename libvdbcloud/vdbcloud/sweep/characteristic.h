#pragma once
// Radiance at the end of a characteristic, eight voxels at once: the formula of transport_sweep.h. Private to sweep/.
#include "vdbcloud/sweep/lanes.h"

namespace vdbcloud::lanes {

inline constexpr float series_below = 0.3f;

/// ((1 - e^-t) / t - e^-t) / t by its series, for t below `series_below`.
VDBCLOUD_INLINE Lanes ramp_series(Lanes t)
{
    const Lanes tt = t * t;
    return (all(0.5f) - t * all(1.0f / 3)) +
           tt * ((all(1.0f / 8) - t * all(1.0f / 30)) + tt * (all(1.0f / 144) - t * all(1.0f / 840)));
}

/// (1 - e^-t) / t by its series, for t below `series_below`.
VDBCLOUD_INLINE Lanes mean_series(Lanes t)
{
    const Lanes tt = t * t;
    return (all(1.0f) - t * all(0.5f)) + tt * ((all(1.0f / 6) - t * all(1.0f / 24)) +
                                               tt * ((all(1.0f / 120) - t * all(1.0f / 720)) + tt * all(1.0f / 5040)));
}

/// (m - 2 r) / t by its series, m = (1 - e^-t) / t, r = (m - e^-t) / t, for t below `series_below`.
VDBCLOUD_INLINE Lanes lean_series(Lanes t)
{
    Lanes s = all(1.0f / 1008) - t * all(1.0f / 6720);
    s = all(1.0f / 180) - t * s;
    s = all(1.0f / 40) - t * s;
    s = all(1.0f / 12) - t * s;
    return all(1.0f / 6) - t * s;
}

/// What the end of a characteristic takes of the medium, whatever its light: computed once for all channels of a sweep.
/// `sigma_u` where the characteristic begins, `sigma` where it ends; `half`: half its length [world unit].
///
/// `emission`: the source is linear in length, not q.
template<bool emission>
struct Passage {
    VDBCLOUD_INLINE Passage(Lanes sigma_u, Lanes sigma, Lanes half)
    {
        const Lanes t = (sigma_u + sigma) * half;
        // Where t is small 1 - e^-t has its own rounding, and both add up to 1: a furnace stays exact. Most rows are
        // thin or thick as a whole, and a lane does not depend on what others take.
        const Ints thin = t < all(series_below);
        Lanes ramp = all(0.0f);
        if (any(thin)) {
            lost_ = t * mean_series(t);
            e_ = all(1.0f) - lost_;
            ramp = t * ramp_series(t);
        }
        const bool some_thick = any(~thin);
        if (some_thick) {
            const Lanes by_exp = exp_minus(at_most(t, 80.0f));
            lost_ = thin ? lost_ : all(1.0f) - by_exp;
            e_ = thin ? e_ : by_exp;
        }
        if constexpr (emission) {
            take_emission(sigma_u, sigma, all(2.0f) * half);
        } else {
            // 1 / sigma_u, 1 / t and 1 / lean by one division.
            const Lanes divisor = at_least(sigma_u, 1e-30f), length = at_least(t, series_below);
            const Lanes lean = all(6.0f) + t * (all(3.0f) + t), both = divisor * length;
            const Lanes inverse = all(1.0f) / (both * lean), inverse_both = inverse * lean;
            of_source_ = inverse_both * length;
            begins_ = sigma_u > all(0.0f);
            ends_ = sigma > all(0.0f);
            if (some_thick) ramp = thin ? ramp : lost_ * (inverse_both * divisor) - e_;
            of_slope_ = ramp - (sigma - sigma_u) * half * (inverse * both);
        }
    }

    /// Radiance at the end from `radiance` and `source_u` = sigma_t q at the beginning, and `own` = q and `emitted` =
    /// sigma_t q at the end.
    VDBCLOUD_INLINE Lanes operator()(Lanes radiance, Lanes source_u, Lanes own, Lanes emitted) const
    {
        if constexpr (emission)
            return radiance * e_ + lost_ * (all(2.0f) * source_u * of_source_ + emitted * of_slope_) / divisor_;
        const Lanes q_u = begins_ ? source_u * of_source_ : own;
        const Lanes q = ends_ ? own : q_u;
        return radiance * e_ + q * lost_ + (q_u - q) * of_slope_;
    }

private:
    /// Of emission S, linear in length, `lost` of other light: S_u and S are weighted by what is above 0 alone. (In the
    /// weight of q = S / sigma_t that a thin voxel has beside a dense one all digits would cancel.)
    VDBCLOUD_INLINE void take_emission(Lanes sigma_u, Lanes sigma, Lanes length)
    {
        const Lanes x = sigma * length, e_x = exp_minus(at_most(x, 80.0f)),
                    inverse = all(1.0f) / at_least(x, series_below);
        // Integrals of e^-xs and of s e^-xs over 0 < s < 1, and the first less twice the second, over x.
        const auto thin = x < all(series_below);
        const Lanes ramp = thin ? ramp_series(x) : ((all(1.0f) - e_x) * inverse - e_x) * inverse, mean = x * ramp + e_x;
        const Lanes lean = thin ? lean_series(x) : (mean - all(2.0f) * ramp) * inverse;
        of_source_ = ramp;
        of_slope_ = mean + sigma_u * length * lean;
        divisor_ = at_least(sigma_u + sigma, 1e-30f) * mean;
    }
    Lanes e_{}, lost_{}, of_source_, of_slope_, divisor_;
    Ints begins_, ends_;
};

/// `radiance`, `sigma_u`, `source_u` = sigma_t q where the characteristic begins; `sigma`, `own` = q where it ends.
template<bool emission>
VDBCLOUD_INLINE Lanes characteristic(Lanes radiance, Lanes sigma_u, Lanes source_u, Lanes sigma, Lanes own, Lanes half)
{
    return Passage<emission>(sigma_u, sigma, half)(radiance, source_u, own, sigma * own);
}

}  // namespace vdbcloud::lanes
