#include "vdbcloud/optics/phase_function.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud {

namespace {
}

PhaseFunction::PhaseFunction(PhaseKind kind, double g) : kind_(kind), g_(kind == PhaseKind::HenyeyGreenstein ? g : 0.0)
{
    if (!(g > -1 && g < 1)) throw InputError("g = " + std::to_string(g) + ": expected a number in (-1, 1)");
}

double PhaseFunction::operator()(double cos_theta) const
{
    switch (kind_) {
    case PhaseKind::Isotropic: break;
    case PhaseKind::Rayleigh: return 3.0 / (16.0 * pi) * (1.0 + cos_theta * cos_theta);
    case PhaseKind::HenyeyGreenstein: {
        // (1-g)^2 + 2g(1-c) is 1 + g^2 - 2gc, without the cancellation that costs digits at g near 1, c near
        // 1; likewise a (1 + g) for 1 - g^2.
        const double a = 1.0 - g_;
        const double d = a * a + 2.0 * g_ * (1.0 - cos_theta);
        return a * (1.0 + g_) / (4.0 * pi * d * std::sqrt(d));
    }
    }
    return 1.0 / (4.0 * pi);
}

double PhaseFunction::moment(int l) const
{
    if (l == 0) return 1.0;
    switch (kind_) {
    case PhaseKind::Isotropic: return 0.0;
    case PhaseKind::Rayleigh: return l == 2 ? 0.1 : 0.0;
    case PhaseKind::HenyeyGreenstein: return std::pow(g_, l);
    }
    return 0.0;
}

}  // namespace vdbcloud
