#include "vdbcloud/render/block_errors.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace vdbcloud {

namespace {

constexpr double level = 0.975;  // 95 % between both ends

double luminance_of(const Vec3d& x) { return luminance(x[0], x[1], x[2]); }

double total_weight(const std::vector<BatchMean>& blocks)
{
    double sum = 0;
    for (const BatchMean& b : blocks) sum += b.weight;
    return sum;
}

/// Degrees of freedom of a sum of variances, each of which is known from `batches` values (Satterthwaite 1946).
double freedom(const std::vector<double>& variances, int batches)
{
    double sum = 0, squares = 0;
    for (const double v : variances) {
        sum += v;
        squares += v * v;
    }
    return (batches - 1) * (squares > 0 ? sum * sum / squares : 1);
}

/// Mean over batches of `value(k)`, and the variance of the mean.
template<typename Value>
std::pair<double, double> over_batches(int first, int stride, int count, const Value& value)
{
    double mean = 0, squares = 0;
    for (int n = 0; n < count; ++n) {
        const double x = value(first + n * stride), before = x - mean;
        mean += before / (n + 1);
        squares += before * (x - mean);
    }
    return {mean, count > 1 ? squares / (double(count) * (count - 1)) : 0};
}

/// Standard deviations that an estimate of the spread of true values has to exceed before it is believed. Estimates are
/// then 0 where noise alone spreads the means, but for one case in some thousands.
constexpr double doubt = 5;

/// Mean square of true values, found as a weighted sum of x^2 - noise.
struct Spread {
    double weight = 0, sum = 0, variance = 0;

    void add(double w, double x, double noise)
    {
        weight += w;
        sum += w * (x * x - noise);
        variance += 2 * w * w * noise * noise;
    }
    double square() const { return weight > 0 ? std::max(0.0, sum - doubt * std::sqrt(variance)) / weight : 0; }
    /// Part of an estimate of variance `noise` that is kept.
    double kept(double noise) const { return square() > 0 ? square() / (square() + noise) : 0; }
};

}  // namespace

double student_quantile(double degrees, double u)
{
    return boost::math::quantile(boost::math::students_t(std::max(degrees, 1.0)), u);
}

Interval mean_error(const std::vector<BatchMean>& blocks, int batches)
{
    const double all = total_weight(blocks);
    double mean = 0, variance = 0;
    std::vector<double> parts;
    for (const BatchMean& b : blocks) {
        const double w = b.weight / all;
        mean += w * b.mean;
        parts.push_back(w * w * b.variance);
        variance += parts.back();
    }
    const double half = student_quantile(freedom(parts, batches), level) * std::sqrt(variance);
    return {mean, mean - half, mean + half};
}

Interval mean_square_error(const std::vector<BatchMean>& blocks, int batches)
{
    const double all = total_weight(blocks), k = batches;
    // `own`: variance of the estimate where there is no error. `met`: of its part in proportion to the error, times the
    // error. `even`: 4 sum w^2 v.
    double estimate = 0, own = 0, met = 0, even = 0;
    std::vector<double> parts;
    for (const BatchMean& b : blocks) {
        const double w = b.weight / all, v = b.variance, square = b.mean * b.mean - v;
        estimate += w * square;
        // v^2 is (k + 1) / (k - 1) times too large in the mean.
        parts.push_back(2 * w * w * v * v * k / (k + 1));
        own += parts.back();
        met += 4 * w * w * square * v;
        even += 4 * w * w * v;
    }
    const double t = student_quantile(freedom(parts, batches), level);
    const double seen = estimate > 2 * std::sqrt(own) ? met / estimate : 0;
    const double slope = std::max(even, seen), middle = estimate + t * t * slope / 2;
    const double half = t * std::sqrt(std::max(0.0, own + slope * estimate + t * t * slope * slope / 4));
    return {estimate, std::max(0.0, middle - half), std::max(std::sqrt(own), middle + half)};
}

BlockErrors::BlockErrors(int across, int down, std::vector<double> weights)
    : across_(across), down_(down), weights_(std::move(weights)), sums_(weights_.size() * batches, Vec3d(0, 0, 0))
{
}

void BlockErrors::add(size_t b, uint64_t pass, const Vec3d& error) { sums_[b * batches + pass % batches] += error; }

int BlockErrors::count(uint64_t passes, const BatchPart& part)
{
    const int used = int(std::min<uint64_t>(passes, batches));
    return std::max(0, (used - part.first + part.stride - 1) / part.stride);
}

/// What a batch says: the mean over its passes.
Vec3d BlockErrors::estimate(size_t b, int batch, uint64_t passes) const
{
    const uint64_t before = passes / batches, more = passes % batches;
    return sums_[b * batches + size_t(batch)] / double(before + (uint64_t(batch) < more ? 1 : 0));
}

std::vector<BatchMean> BlockErrors::fine(uint64_t passes, const BatchPart& part, const std::vector<Vec3d>& known) const
{
    std::vector<BatchMean> out;
    for (size_t b = 0; b < weights_.size(); ++b) {
        if (!(weights_[b] > 0)) continue;
        const double off = known.empty() ? 0 : luminance_of(known[b]);
        const auto [mean, variance] = over_batches(part.first, part.stride, count(passes, part),
                                                   [&](int k) { return luminance_of(estimate(b, k, passes)) - off; });
        out.push_back({weights_[b], mean, variance});
    }
    return out;
}

size_t BlockErrors::coarse_of(size_t b) const
{
    const size_t across = size_t((across_ + coarse - 1) / coarse);
    return b / size_t(across_) / coarse * across + b % size_t(across_) / coarse;
}

size_t BlockErrors::coarse_count() const
{
    return size_t((across_ + coarse - 1) / coarse) * size_t((down_ + coarse - 1) / coarse);
}

std::vector<BatchMean> BlockErrors::coarse_blocks(uint64_t passes, const BatchPart& part,
                                                  const std::vector<Vec3d>& known) const
{
    const int used = count(passes, part);
    std::vector<double> weight(coarse_count()), sums(coarse_count() * size_t(used));
    for (size_t b = 0; b < weights_.size(); ++b) {
        if (!(weights_[b] > 0)) continue;
        weight[coarse_of(b)] += weights_[b];
        const double off = known.empty() ? 0 : luminance_of(known[b]);
        for (int n = 0; n < used; ++n)
            sums[coarse_of(b) * size_t(used) + size_t(n)] +=
                weights_[b] * (luminance_of(estimate(b, part.first + n * part.stride, passes)) - off);
    }
    std::vector<BatchMean> out;
    for (size_t c = 0; c < weight.size(); ++c) {
        if (!(weight[c] > 0)) continue;
        const auto [mean, variance] =
            over_batches(0, 1, used, [&](int n) { return sums[c * size_t(used) + size_t(n)] / weight[c]; });
        out.push_back({weight[c], mean, variance});
    }
    return out;
}

Vec3d BlockErrors::mean(size_t b, uint64_t passes, const BatchPart& part) const
{
    Vec3d sum(0, 0, 0);
    const int used = count(passes, part);
    for (int n = 0; n < used; ++n) sum += estimate(b, part.first + n * part.stride, passes);
    return sum / double(std::max(1, used));
}

double BlockErrors::variance(size_t b, uint64_t passes, const BatchPart& part) const
{
    return over_batches(part.first, part.stride, count(passes, part),
                        [&](int k) { return luminance_of(estimate(b, k, passes)); })
        .second;
}

std::vector<Vec3d> BlockErrors::shrunk(uint64_t passes, const BatchPart& part) const
{
    const size_t count = weights_.size();
    std::vector<Vec3d> means(count, Vec3d(0, 0, 0)), out(count, Vec3d(0, 0, 0)), sums(coarse_count(), Vec3d(0, 0, 0));
    std::vector<double> noise(count), weight(coarse_count()), noise_of_sum(coarse_count());
    for (size_t b = 0; b < count; ++b) {
        if (!(weights_[b] > 0)) continue;
        means[b] = mean(b, passes, part);
        noise[b] = variance(b, passes, part);
        const size_t c = coarse_of(b);
        weight[c] += weights_[b];
        sums[c] += weights_[b] * means[b];
        noise_of_sum[c] += weights_[b] * weights_[b] * noise[b];
    }
    Spread spread, rest;
    for (size_t c = 0; c < weight.size(); ++c) {
        if (!(weight[c] > 0)) continue;
        sums[c] /= weight[c];
        noise_of_sum[c] /= weight[c] * weight[c];
        spread.add(weight[c], luminance_of(sums[c]), noise_of_sum[c]);
    }
    // What a fine block has beside the coarse block's part that is kept, and the variance of the difference.
    const auto kept_of = [&](size_t c) { return spread.kept(noise_of_sum[c]); };
    const auto beside = [&](size_t b) {
        const size_t c = coarse_of(b);
        const double k = kept_of(c);
        return noise[b] * (1 - 2 * k * weights_[b] / weight[c]) + k * k * noise_of_sum[c];
    };
    for (size_t b = 0; b < count; ++b) {
        if (!(weights_[b] > 0)) continue;
        const size_t c = coarse_of(b);
        out[b] = kept_of(c) * sums[c];
        rest.add(weights_[b], luminance_of(means[b] - out[b]), beside(b));
    }
    for (size_t b = 0; b < count; ++b)
        if (weights_[b] > 0) out[b] += rest.kept(beside(b)) * (means[b] - out[b]);
    return out;
}

}  // namespace vdbcloud
