#include "vdbcloud/render/forward_peak.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double deepest = 64, full = pi / 4, none = 5 * pi / 12;  // beyond `none` the ratio is 1
constexpr int angles = 96, depths = 64;

double angle_of(int i) { return none * (double(i) / (angles - 1)) * (double(i) / (angles - 1)); }
double depth_of(int j) { return std::expm1(std::log1p(deepest) * j / (depths - 1)); }

/// 1 up to `full`, 0 from `none` on.
double share(double angle)
{
    const double s = std::clamp((none - angle) / (none - full), 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

/// e^u - 1 - u.
double beyond_first(double u) { return std::abs(u) < 1e-4 ? u * u / 2 : std::expm1(u) - u; }

}  // namespace

ForwardPeak::ForwardPeak(double g, int degree) : g_(g), f_(std::pow(g, degree + 1)), degree_(degree)
{
    table_.reserve(size_t(angles) * depths);
    for (int i = 0; i < angles; ++i)
        for (int j = 0; j < depths; ++j)
            table_.push_back(float(1 + share(angle_of(i)) * (exact(std::cos(angle_of(i)), depth_of(j)) - 1)));
}

/// The sum over all l of a constant is 0 off the forward direction: taking off the term that l tends to leaves one that
/// converges.
double ForwardPeak::exact(double cosine, double x) const
{
    if (x == 0) return 1;
    const double p = (1 - g_ * g_) / std::pow(1 + g_ * g_ - 2 * g_ * cosine, 1.5), limit = beyond_first(-x * f_);
    double sum = 0, before = 0, legendre = 1, power = 1;
    for (int l = 0; l <= degree_ || x * power > 1e-9; ++l) {
        sum += (2 * l + 1) * legendre * ((l > degree_ ? beyond_first(x * (power - f_)) : 0.0) - limit);
        const double next = ((2 * l + 1) * cosine * legendre - l * before) / (l + 1);
        before = legendre;
        legendre = next;
        power *= g_;
    }
    return std::max(0.0, 1 + sum / (x * p));
}

double ForwardPeak::operator()(double cosine, double x) const
{
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    if (angle >= none) return 1;
    const double a = std::sqrt(angle / none) * (angles - 1),
                 d = std::log1p(std::clamp(x, 0.0, deepest)) / std::log1p(deepest) * (depths - 1);
    const int i = std::min(int(a), angles - 2), j = std::min(int(d), depths - 2);
    const double u = a - i, v = d - j;
    const float* t = &table_[size_t(i) * depths + size_t(j)];
    return (1 - u) * ((1 - v) * t[0] + v * t[1]) + u * ((1 - v) * t[depths] + v * t[depths + 1]);
}

}  // namespace vdbcloud
