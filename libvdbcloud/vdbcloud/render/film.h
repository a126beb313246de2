#pragma once
// The film: named layers of pixels, and how they gather samples.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/render/pixel_filter.h"
#include "vdbcloud/scene/camera.h"

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

/// How a pixel combines its samples.
enum class Combine {
    Mean,     ///< weighted by the reconstruction filter
    Nearest,  ///< the smallest: for depth, whose mean with "infinite" is undefined
    Sum,      ///< over the samples: for the time that a pixel took
};

/// One output variable (AOV).
struct LayerSpec {
    std::string name;                   ///< "" for the beauty, whose channels are R, G, B, A
    std::vector<std::string> channels;  ///< "R", "G", "B"; "Z"; "Y"
    bool half = true;                   ///< stored as half in files: colour; false for Z, variance and transmittance
    Combine combine = Combine::Mean;
    bool stored = true;  ///< in files
};

/// Layers of floats over the wanted window of a picture.
class Film {
public:
    /// Throws InputError if two layers share a name or a layer has no channel.
    Film(const ImageSize&, std::vector<LayerSpec> layers);

    const ImageSize& size() const { return size_; }
    const PixelWindow& window() const { return window_; }
    const std::vector<LayerSpec>& layers() const { return layers_; }
    int channels() const { return channels_; }  ///< of all layers together

    /// Index of a layer, -1 if there is none of that name.
    int find(const std::string& layer) const;
    /// First channel of a layer, in pixel().
    int offset(int layer) const { return offsets_[size_t(layer)]; }
    /// The channels() floats of pixel (i, j), which must be in window(): layers in order, channels in order.
    float* pixel(int i, int j);
    const float* pixel(int i, int j) const;

private:
    ImageSize size_;
    PixelWindow window_;
    std::vector<LayerSpec> layers_;
    std::vector<int> offsets_;
    int channels_ = 0;
    std::vector<float> data_;
};

/// Computes the picture at point (x, y) [pixels, as in CameraView]: fills `channels()` values. Called from
/// many threads.
using SampleFunction = std::function<void(double x, double y, double* out)>;

/// Called once in each thread; that thread alone calls the function that is returned, which may keep caches.
using SamplerFactory = std::function<SampleFunction()>;

/// Fills the film, in tiles over all threads. A layer "variance" with one channel is not the sampler's: it
/// becomes the estimated variance of the pixel's mean luminance in the beauty layer (0 with one sample), and
/// its place in `out` is ignored.
///
/// The picture is the same whatever the number of threads: a pixel's samples depend on its coordinates only
/// and are added in order. A crop has the pixels of the whole picture. Throws ConvergenceError naming the
/// pixel and the layer if a value is not finite; Cancelled.
void expose(Film&, const SamplingOptions&, const SamplerFactory&, const Progress& = {});

/// Throws ConvergenceError naming the pixel and the layer of a value that is not finite.
[[noreturn]] void refuse_value(const Film&, int channel, int i, int j, double value);

/// Rec. 709 luminance.
inline double luminance(double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }

}  // namespace vdbcloud
