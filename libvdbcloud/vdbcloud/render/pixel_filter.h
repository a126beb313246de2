#pragma once
// Reconstruction filters: where in and around a pixel its samples lie.
#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

enum class FilterKind { Box, Gaussian, BlackmanHarris };

const char* name(FilterKind);
FilterKind filter_kind(const std::string& name);  ///< Throws InputError with the names that there are.

inline constexpr int most_samples = 1 << 24;  ///< whole numbers that a float holds

struct SamplingOptions {
    int samples = 1;  ///< per pixel, 1 to most_samples; one is taken at the pixel's centre, whatever the filter
    FilterKind filter = FilterKind::Box;
    double filter_width = 0;  ///< full width [pixels], 0: the filter's own (box 1, the others 3)
    uint64_t seed = 0;
};

/// A place on the film, relative to the pixel's centre [pixels].
struct SampleOffset {
    double x, y;
};

/// Separable filters f(x) f(y) on [-w/2, w/2], each normalised to integral 1:
///
///     box               constant
///     Gaussian          exp(-x^2 / 2 s^2), s = w/6, cut off at three standard deviations
///     Blackman-Harris   0.35875 + 0.48829 cos u + 0.14128 cos 2u + 0.01168 cos 3u, u = 2 pi x / w (Harris
///     1978, four terms)
///
/// A pixel's samples are placed with the filter as their density (inverse cumulative distribution), so each
/// has the weight 1/samples: weights sum to one exactly, and no pixel needs its neighbours' samples. Within a
/// pixel they are a Hammersley set, turned round by a hash of (seed, i, j): well spread, and a function of
/// the pixel alone. Immutable after construction; share it between threads.
class PixelFilter {
public:
    /// Throws InputError if samples or filter_width is out of range.
    explicit PixelFilter(const SamplingOptions&);

    int samples() const { return options_.samples; }

    /// Sample k of pixel (i, j), 0 <= k < samples().
    SampleOffset operator()(int i, int j, int k) const;

    /// The x below which a share u of the filter lies, u in [0, 1] [pixels].
    double inverse_cumulative(double u) const;

private:
    SamplingOptions options_;
    std::vector<double> table_;  // inverse_cumulative at k / (size - 1)
};

/// The filter's share below x [pixels], in closed form: 0 at -width/2, 1 at width/2.
double cumulative(FilterKind, double width, double x);

}  // namespace vdbcloud
