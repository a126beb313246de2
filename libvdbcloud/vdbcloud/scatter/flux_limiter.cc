#include "vdbcloud/scatter/flux_limiter.h"

#include "vdbcloud/scatter/active_slots.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

double levermore_pomraning(double r)
{
    if (r < 1e-2) return 1 - r * r / 15;  // the next term is 2 r^4 / 315
    return 3 * (1 / std::tanh(r) - 1 / r) / r;
}

FluxLimiter::FluxLimiter(const Blocks& blocks) : blocks_(blocks), factor_(blocks.slots(), 1.0f) {}

void FluxLimiter::update(const std::vector<double>& phi, const std::array<std::vector<float>, 3>& flux)
{
    each_active(blocks_, [&](size_t slot) {
        if (!(phi[slot] > 0)) return;
        double square = 0;
        for (const auto& component : flux) square += double(component[slot]) * component[slot];
        const double r = 3 * std::sqrt(square) / (factor_[slot] * phi[slot]);
        factor_[slot] = float(std::sqrt(factor_[slot] * std::max(levermore_pomraning(r), 1e-6)));
    });
}

double FluxLimiter::least() const
{
    float least = 1;
    for (size_t slot = 0; slot < blocks_.count() * 512; ++slot)
        if (blocks_.active(slot)) least = std::min(least, factor_[slot]);
    return least;
}

double relative_change(const std::vector<double>& a, const std::vector<double>& b)
{
    double difference = 0, size = 0;
    for (size_t n = 0; n < a.size(); ++n) {
        difference += (a[n] - b[n]) * (a[n] - b[n]);
        size += a[n] * a[n];
    }
    return size > 0 ? std::sqrt(difference / size) : 0.0;
}

}  // namespace vdbcloud
