#include "vdbcloud/render/forward_peak.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

/// (2l+1) P_l(cosine), l = 0 .. count - 1.
std::vector<double> weighted_legendre(double cosine, size_t count)
{
    std::vector<double> weighted(count);
    double before = 0, legendre = 1;
    for (size_t l = 0; l < count; ++l) {
        weighted[l] = double(2 * l + 1) * legendre;
        const double next = (double(2 * l + 1) * cosine * legendre - double(l) * before) / double(l + 1);
        before = legendre;
        legendre = next;
    }
    return weighted;
}

/// e^u - 1 - u of every degree at one x, 0 up to the degree of the scaling, minus its limit at high degree. Off the
/// forward direction the sum of a constant over all l is 0. Without this constant the sum over l converges.
std::vector<double> terms(const std::vector<double>& moments, const DeltaScaling& scaling, double x)
{
    const double limit = beyond_first(-x * scaling.delta_f);
    std::vector<double> terms;
    for (size_t l = 0; l < moments.size(); ++l)
        terms.push_back((int(l) > scaling.degree ? beyond_first(x * (moments[l] - scaling.delta_f)) : 0.0) - limit);
    return terms;
}

}  // namespace

ForwardPeak::ForwardPeak(const PhaseFunction& phase, const DeltaScaling& scaling)
{
    std::vector<double> moments;
    const int count = std::max(scaling.degree + 1, phase.degree_below(1e-9 / deepest));
    for (int l = 0; l < count; ++l) moments.push_back(phase.moment(l));
    std::vector<std::vector<double>> at_depth;
    for (int j = 0; j < depths; ++j) at_depth.push_back(terms(moments, scaling, depth_of(j)));
    table_.reserve(size_t(angles) * depths);
    for (int i = 0; i < angles; ++i) {
        const double cosine = std::cos(angle_of(i)), p = 4 * pi * phase(cosine);
        const auto weighted = weighted_legendre(cosine, moments.size());
        for (int j = 0; j < depths; ++j) {
            const double x = depth_of(j);
            const double sum = std::inner_product(weighted.begin(), weighted.end(), at_depth[size_t(j)].begin(), 0.0);
            const double ratio = x > 0 ? std::max(0.0, 1 + sum / (x * p)) : 1;
            table_.push_back(float(1 + share(angle_of(i)) * (ratio - 1)));
        }
    }
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
