#pragma once
// What the rules of the integrators share. Private to render/.
#include "vdbcloud/render/media.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbcloud {

inline constexpr double log_2 = 0.69314718055994531;
/// Optical depth beyond which sources on the ray are not visible: exp(-45) = 3e-20.
inline constexpr double opaque = 45;

/// The mean of exp(-x s) over s in [0, 1] times `at_0`, given at_1 = at_0 exp(-x) computed apart.
inline double mean_exponential(double at_0, double at_1, double x)
{
    if (std::abs(x) > 1e-2) return (at_0 - at_1) / x;
    return at_0 * (1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5))));
}

/// The part of a step, 0 to 1, after which the mean over channels of exp(-tau) has fallen to 1/2, with tau0 at the
/// step's start and tau1 at its end; the logarithm of the mean is taken as linear between. None: above 1/2 throughout.
inline std::optional<double> part_to_half(const Vec3d& tau0, const Vec3d& tau1)
{
    if (std::max({tau1[0], tau1[1], tau1[2]}) < log_2) return std::nullopt;
    const auto mean = [](const Vec3d& tau) { return (std::exp(-tau[0]) + std::exp(-tau[1]) + std::exp(-tau[2])) / 3; };
    const double after = mean(tau1);
    if (after > 0.5) return std::nullopt;
    const double before = mean(tau0);
    return std::log(before / 0.5) / std::log(before / std::max(after, 1e-300));
}

}  // namespace vdbcloud
