#pragma once
// A picture that is there in a moment and sharpens. Private to render/.
#include "vdbcloud/render/passes.h"

namespace vdbcloud {

/// Fills the film as expose() does, each pixel once, in four rounds: of every 8 x 8 pixels one, then of 4 x 4, of 2 x
/// 2, then all. Shows the picture as options.show asks, and after the first round ends where options.time_limit is
/// exceeded. Pixels that are not computed have the values of the pixel that stands for them: the first of the smallest
/// block whose first pixel is computed. Each pixel that is computed has the values that expose() gives it.
CoarseReport expose_coarse_first(Film&, const SamplingOptions&, const PassOptions&, const SamplerFactory&,
                                 const Progress& = {});

/// When to show a picture that is not complete. At most once in `interval`, and so that showing takes a tenth of the
/// time at the most.
class Showing {
public:
    explicit Showing(const PassOptions& options) : options_(options) {}
    bool due() const;
    /// Calls options.show and notes the time that it took.
    void show(const Film&, const ShownPicture&);

private:
    const PassOptions& options_;
    double last_ = -1e30, taken_ = 0;  // [s of the clock]
};

/// Seconds of a clock that only goes forward.
double clock_seconds();

}  // namespace vdbcloud
