#include "vdbcloud/render/pixel_filter.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/words.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr auto kinds = words<FilterKind>(
    "filter",
    {{FilterKind::Box, "box"}, {FilterKind::Gaussian, "gaussian"}, {FilterKind::BlackmanHarris, "blackman-harris"}});

constexpr int intervals = 2048;  // of the table: off by less than 1e-3 pixel in the tails, 1e-6 elsewhere

double own_width(FilterKind kind) { return kind == FilterKind::Box ? 1 : 3; }

/// k with its bits reversed behind the binary point (van der Corput 1935).
double radical_inverse(uint32_t k)
{
    uint32_t reversed = 0;
    for (int bit = 0; bit < 32; ++bit, k >>= 1) reversed = (reversed << 1) | (k & 1);
    return reversed * 0x1p-32;
}

double fraction(double x) { return x - std::floor(x); }

/// Solves cumulative(x) = u by bisection, to the last bit.
double inverted(FilterKind kind, double width, double u)
{
    double low = -width / 2, high = width / 2;
    for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        (cumulative(kind, width, middle) < u ? low : high) = middle;
    }
    return (low + high) / 2;
}

}  // namespace

const char* name(FilterKind kind) { return kinds.word(kind); }

FilterKind filter_kind(const std::string& text) { return kinds.value(text); }

double cumulative(FilterKind kind, double width, double x)
{
    const double t = std::clamp(x / width, -0.5, 0.5);
    switch (kind) {
    case FilterKind::Box: break;
    case FilterKind::Gaussian: {
        const double a = 6 / std::sqrt(2.0);
        return 0.5 + 0.5 * std::erf(a * t) / std::erf(a / 2);
    }
    case FilterKind::BlackmanHarris: {
        const double u = 2 * pi * t;
        return 0.5 + t +
               (0.48829 * std::sin(u) + 0.14128 * std::sin(2 * u) / 2 + 0.01168 * std::sin(3 * u) / 3) /
                   (2 * pi * 0.35875);
    }
    }
    return 0.5 + t;
}

PixelFilter::PixelFilter(const SamplingOptions& options) : options_(options)
{
    if (options.samples < 1 || options.samples > most_samples)
        throw InputError("samples per pixel " + std::to_string(options.samples) + ": expected 1 to " +
                         std::to_string(most_samples));
    if (!(options.filter_width >= 0 && options.filter_width <= 64))
        throw InputError("filter width " + std::to_string(options.filter_width) + ": expected 0 to 64 pixels");
    const double width = options.filter_width > 0 ? options.filter_width : own_width(options.filter);
    for (int k = 0; k <= intervals; ++k) table_.push_back(inverted(options.filter, width, double(k) / intervals));
}

double PixelFilter::inverse_cumulative(double u) const
{
    const double place = std::clamp(u, 0.0, 1.0) * intervals;
    const auto k = std::min(size_t(place), size_t(intervals - 1));
    return table_[k] + (place - double(k)) * (table_[k + 1] - table_[k]);
}

SampleOffset PixelFilter::operator()(int i, int j, int k) const
{
    if (options_.samples == 1) return {0, 0};
    const uint64_t bits = hash_bits(options_.seed, uint64_t(uint32_t(i)), uint64_t(uint32_t(j)));
    const double u = fraction((k + 0.5) / options_.samples + uniform(bits));
    const double v = fraction(radical_inverse(uint32_t(k)) + uniform(hash_bits(bits)));
    return {inverse_cumulative(u), inverse_cumulative(v)};
}

}  // namespace vdbcloud
