#pragma once
// How far a picture is from the truth: measured by a few unbiased light paths, bias included.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/render/integrator.h"

#include <vector>

namespace vdbcloud {

/// An estimate and the ends of its interval of 95 % confidence.
struct Interval {
    double value = 0, low = 0, high = 0;
};

struct CertifyOptions {
    double seconds = 0;     ///< ends after the pass that exceeds it [s of the clock]; 0: no limit
    double half_width = 0;  ///< ends when the interval of the error over 32 x 32 pixels is at most this to each side
                            ///< [relative]; 0: no target
    uint64_t passes = 0;    ///< ends after so many, 8 at the least; 0: no number
    bool correct = false;   ///< improve the picture by what was found
};

/// Errors of a picture's luminance, relative to the mean luminance of the true picture. Only pixels count that see the
/// media, or have a neighbour that does.
struct Certificate {
    double luminance = 0;  ///< mean of the true picture over these pixels
    Interval bias;         ///< mean of picture - truth
    Interval fine;         ///< root mean square over blocks of 8 x 8 pixels of the blocks' mean error; low 0: `high` is
                           ///< an upper bound
    Interval coarse;       ///< the same over 32 x 32 pixels
    uint64_t samples = 0;  ///< light paths from the camera
    uint64_t passes = 0;
    double heaviest = 0;  ///< share of the samples' squares that the largest one has
    bool reached = true;  ///< the half-width asked for
    RenderCost cost;      ///< of the light paths

    /// Where one sample holds so much, intervals cannot be relied on: the noise has a heavy tail that most runs miss.
    static constexpr double most_by_one = 0.05;
    bool reliable() const { return heaviest <= most_by_one; }
};

/// The layers that certify() reads or fills beside those of render_layers(), for a film that is to be certified:
///
///     "sky"             R G B  the scene's sky behind the media, where that is not the background; not stored in files
///     "block_error"     R G B  picture - truth in the mean over the pixel's block of 8 x 8 pixels, as measured, before
///                              a correction
///     "block_deviation" Y      standard error of that, of luminance
///     "block_guess"     Y      the measured error of luminance shrunk by its noise; not stored in files
///     "correction"      R G B  what a correction has added to R, G, B; with `correct` alone
std::vector<LayerSpec> certificate_layers(const Scene&, bool correct);

/// Compares a picture with light paths of its scene (path.h) that are independent of all others of that seed.
///
/// The truth is what a picture of whole light paths with the same pixel filter converges to: the solution of the
/// transport equation for the trilinear interpolant of the scene's grids, with scene.sky behind it and lighting it.
/// What the grids' voxels and the phase function miss of nature is no part of it. `picture` has the layers of
/// render_layers() and certificate_layers().
///
/// Each pass takes a few samples in each block of 8 x 8 pixels, at pixels drawn at random; blocks that the picture has
/// brighter take more. Batches of passes are independent: the mean over pairs of batches of the product of the blocks'
/// errors is an unbiased estimate of the picture's mean square error (block_errors.h).
///
/// With `correct` the picture loses the guess at its error by shrunk means of blocks, interpolated between blocks and
/// weighted with alpha, so that edges stay. The certificate is then that of
/// the corrected picture, by cross-fitting: corrections by one half of the batches are judged by the other half. The
/// correction by all batches, which the picture has, has less noise than these.
///
/// Ends by what comes first; without a limit after 8 passes. Deterministic for any number of threads; with a time limit
/// the number of passes depends on the clock. A run that ends by a half-width looks at it after 16 passes and then each
/// time when there are a quarter as many again.
///
/// Throws InputError for a picture without light, ConvergenceError for a sample that is not finite, Cancelled.
Certificate certify(Film& picture, const Scene&, const CameraView&, const SamplingOptions&, const CertifyOptions&,
                    const Progress& = {});

}  // namespace vdbcloud
