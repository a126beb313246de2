#include "vdbcloud/sim/shape.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim {

Shape::~Shape() = default;

double weight_in(const Shape& shape, const Point& centre, const Point& size, double time)
{
    if (!shape.body()) return shape.value(centre, time);
    constexpr int n = 4;
    const double reach = 0.5 * std::hypot(size[0], size[1], size[2]), middle = shape.distance(centre);
    if (std::abs(middle) > 1.01 * reach) return middle < 0 ? 1 : 0;
    const double part = std::cbrt(size[0] * size[1] * size[2]) / n;
    double sum = 0;
    for (int c = 0; c < n; ++c)
        for (int b = 0; b < n; ++b)
            for (int a = 0; a < n; ++a) {
                const auto at = [&](size_t axis, int i) { return centre[axis] + ((i + 0.5) / n - 0.5) * size[axis]; };
                sum += std::clamp(0.5 - shape.distance({at(0, a), at(1, b), at(2, c)}) / part, 0.0, 1.0);
            }
    return sum / (n * n * n);
}

std::vector<double> FieldSource::step_ends() const
{
    std::vector<double> times = shape->times();
    times.insert(times.end(), {from, until});
    return times;
}

double FieldSource::strength(double step, double t) const
{
    const auto early = [&](double edge) { return edge - 1e-9 * std::max(1.0, edge); };
    if (step < early(from) || step >= early(until)) return 0;
    if (ramp <= 0) return 1;
    const double x = std::clamp(std::min(t - from, until - t) / ramp, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

}  // namespace vdbcloud::sim
