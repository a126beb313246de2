#pragma once
// Pictures from independent random samples: as many as asked for, or until the time is up or the noise is low enough.
#include "vdbcloud/render/film.h"

#include <cstdint>
#include <functional>

namespace vdbcloud {

/// What a picture that is shown before its end holds.
struct ShownPicture {
    int coarseness = 1;    ///< edge of the blocks of pixels of which at least the first is computed; 1: all pixels are
    uint64_t samples = 0;  ///< of each pixel that is computed
};
/// Called with the picture so far, by the thread that renders, while no other thread computes.
using ShowPicture = std::function<void(const Film&, const ShownPicture&)>;

/// How far a picture came that begins with coarse pixels.
struct CoarseReport {
    int coarseness = 0;   ///< as in ShownPicture; 1: complete
    uint64_t pixels = 0;  ///< that are computed; the others have values of their neighbours
};

struct PassOptions {
    uint64_t offset = 0;  ///< index of the first sample; runs with disjoint indices are parts of one run
    /// Path: ends after the pass that exceeds it [s of the clock]; others: ends with the pixels that are computed by
    /// then, at least one of every 8 x 8. 0: no limit.
    double time_limit = 0;
    double noise = 0;  ///< ends after the pass that brings noise() to this or below; 0: no target
    /// The picture's standard error and noise are those of the beauty layer with the background behind it.
    bool over_background = false;
    ShowPicture show;             ///< shows the picture while it is computed; none: it is not shown
    double show_interval = 0.25;  ///< least time between two shown pictures [s of the clock]
};

struct PassReport {
    uint64_t samples = 0;  ///< of each pixel
    double noise = 0;      ///< of the picture: see expose_in_passes()
};

/// Computes sample k of pixel (i, j): fills `channels()` values. Samples must be independent of each other and a
/// function of (i, j, k) alone. Called from many threads.
using IndexedSample = std::function<void(int i, int j, uint64_t k, double* out)>;

/// Called once in each thread; that thread alone calls the function that is returned, which may keep caches.
using IndexedSampleFactory = std::function<IndexedSample()>;

/// Fills the film with the means of at most sampling.samples samples a pixel, from index options.offset on.
///
/// Layers that are not the sampler's:
///
///     "standard_error"  R G B  of the pixel's mean: sqrt(sum (x - mean)^2 / (n (n - 1))) of the beauty; 0 with one sample
///     "variance"        Y      of the pixel's mean luminance, likewise
///     "seconds"         Y      CPU time of the pixel's samples: differs from run to run
///
/// The noise of the picture is the relative standard error of its luminance: the root mean square over pixels of the
/// standard error, over the mean over pixels. With a time limit, a noise target or a picture that is shown, samples are
/// taken in passes over the whole picture, each an eighth of those before, at least one. A noise target is not looked
/// at before 16 samples. A run that ends by a target is slightly biased, as low estimates of the noise end it early:
/// for references, ask for a number of samples.
///
/// The picture is a function of offset and number of samples: not of passes and threads. Throws as expose().
PassReport expose_in_passes(Film&, const SamplingOptions&, const PassOptions&, const IndexedSampleFactory&,
                            const Progress& = {});

}  // namespace vdbcloud
