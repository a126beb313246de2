#pragma once
// How one pixel of a film gathers its samples. Private to render/.
#include "vdbcloud/render/film.h"

#include <vector>

namespace vdbcloud {

/// Fills single pixels of a film. Keeps references to both. Pixels may be filled from many threads, each once.
class Exposure {
public:
    Exposure(Film&, const SamplingOptions&);

    /// Throws ConvergenceError naming the pixel and the layer if a value is not finite.
    void operator()(const SampleFunction&, int i, int j) const;

private:
    Film& film_;
    PixelFilter filter_;
    std::vector<char> nearest_;  // of each channel: Combine::Nearest
    int beauty_ = -1, variance_ = -1;
};

}  // namespace vdbcloud
