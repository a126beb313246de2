#include "vdbcloud/render/forward_peak.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vdbcloud {

namespace {

constexpr double full = pi / 4, none = 5 * pi / 12;  // beyond `none` the ratio is 1
constexpr int angles = 96, depths = ForwardPeak::depths;
constexpr double deepest = ForwardPeak::deepest;

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

/// Degrees between which summands are taken as linear: every degree up to 512, then steps of 1/256 of the degree.
/// Moments fall over 1 / (1 - g) degrees, and e^u - 1 - u is smooth in the logarithm of the degree: the error is below
/// 1e-5.
std::vector<double> knots_up_to(double last)
{
    std::vector<double> knots;
    for (double l = 0; l < last; l = std::floor(l + std::max(1.0, l / 256))) knots.push_back(l);
    knots.push_back(last);
    return knots;
}

/// e^u - 1 - u of the degrees of `knots` at one x, 0 up to the degree of the scaling, minus its limit at high degree.
/// Off the forward direction the sum of a constant over all l is 0. Without this constant the sum over l converges.
std::vector<double> terms(const std::vector<double>& moments, const std::vector<double>& knots,
                          const DeltaScaling& scaling, double x)
{
    const double limit = beyond_first(-x * scaling.delta_f);
    std::vector<double> terms;
    for (size_t k = 0; k < knots.size(); ++k)
        terms.push_back((knots[k] > scaling.degree ? beyond_first(x * (moments[k] - scaling.delta_f)) : 0.0) - limit);
    return terms;
}

/// For each knot the number by which its term counts in the sum of (2l+1) P_l(1) over all degrees.
std::vector<double> weights_forward(const std::vector<double>& knots)
{
    std::vector<double> weights(knots.size(), 0.0);
    for (size_t k = 0; k + 1 < knots.size(); ++k) {  // sums of 2l+1 and of (2l+1) t over a panel, t from 0 below 1
        const double n = knots[k + 1] - knots[k], sum = n * (2 * knots[k] + n),
                     with_t = (n - 1) * ((2 * knots[k] + 1) / 2 + (2 * n - 1) / 3);
        weights[k] += sum - with_t;
        weights[k + 1] += with_t;
    }
    return weights;
}

/// The same of (2l+1) P_l at an angle > 0. Terms vary slowly over the pi / angle degrees between sign changes of P_l,
/// so high degrees cancel. They are faded out by e^-(l angle / 100)^4: smooth, and even in l + 1/2, of which even
/// powers give nothing off the forward direction.
std::vector<double> weights_at(double angle, const std::vector<double>& knots)
{
    const double cosine = std::cos(angle), end = 240 / angle;
    std::vector<double> weights(knots.size(), 0.0);
    double before = 0, legendre = 1, l = 0;
    for (size_t k = 0; k + 1 < knots.size() && l < end; ++k)
        for (const double below = knots[k], above = knots[k + 1]; l < above && l < end; ++l) {
            const double fade = std::exp(-std::pow((l + 0.5) * angle / 100, 4));
            const double weight = fade * (2 * l + 1) * legendre, t = (l - below) / (above - below);
            weights[k] += (1 - t) * weight;
            weights[k + 1] += t * weight;
            const double next = ((2 * l + 1) * cosine * legendre - l * before) / (l + 1);
            before = legendre;
            legendre = next;
        }
    return weights;
}

}  // namespace

ForwardPeak::ForwardPeak(const PhaseFunction& phase, const DeltaScaling& scaling)
{
    const std::vector<double> knots = knots_up_to(std::max(scaling.degree + 1, phase.degree_below(1e-9 / deepest)));
    std::vector<double> moments;
    for (const double l : knots) moments.push_back(phase.moment(int(l)));
    std::vector<std::vector<double>> at_depth;
    for (int j = 0; j < depths; ++j) at_depth.push_back(terms(moments, knots, scaling, depth_of(j)));
    table_.reserve(size_t(angles) * depths);
    for (int i = 0; i < angles; ++i) {
        const double p = 4 * pi * phase(std::cos(angle_of(i)));
        const auto weights = i == 0 ? weights_forward(knots) : weights_at(angle_of(i), knots);
        for (int j = 0; j < depths; ++j) {
            const double x = depth_of(j);
            const double sum = std::inner_product(weights.begin(), weights.end(), at_depth[size_t(j)].begin(), 0.0);
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

std::vector<double> ForwardPeak::at_angle(double cosine) const
{
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    if (angle >= none) return {};
    const double a = std::sqrt(angle / none) * (angles - 1);
    const int i = std::min(int(a), angles - 2);
    const float *below = &table_[size_t(i) * depths], *above = below + depths;
    std::vector<double> row;
    for (int j = 0; j < depths; ++j) row.push_back((1 - (a - i)) * double(below[j]) + (a - i) * double(above[j]));
    return row;
}

}  // namespace vdbcloud
