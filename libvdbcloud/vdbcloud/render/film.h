#pragma once
// The film: named layers of pixels, and how they gather samples.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/scene/camera.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

/// How a pixel combines its samples.
enum class Combine {
    Mean,     ///< weighted by the reconstruction filter
    Nearest,  ///< the smallest: a depth, of which a mean with "infinite" would mean nothing
};

/// One output variable (AOV).
struct LayerSpec {
    std::string name;                   ///< "" for the beauty, whose channels are R, G, B, A
    std::vector<std::string> channels;  ///< "R", "G", "B"; "Z"; "Y"
    bool half = true;                   ///< stored as half in files: colour; false for Z, variance and transmittance
    Combine combine = Combine::Mean;
};

enum class FilterKind { Box, Gaussian, BlackmanHarris };

const char* name(FilterKind);
FilterKind filter_kind(const std::string& name);  ///< Throws InputError with the names that there are.

struct SamplingOptions {
    int samples = 1;                    ///< per pixel; 1 is taken at the pixel's centre, whatever the filter
    FilterKind filter = FilterKind::Box;
    double filter_width = 0;            ///< full width [pixels]; 0: the filter's own (1 box, 3 Gaussian, 3 Blackman-Harris)
    uint64_t seed = 0;
};

/// A place on the film, relative to the pixel's centre [pixels].
struct SampleOffset {
    double x, y;
};

/// The k-th of the samples of pixel (i, j): stratified over the filter's support, jittered by a hash of (seed, i, j, k),
/// and placed with the filter as density (inverse cumulative distribution), so that every sample has the weight
/// 1/samples: weights sum to one by construction and no pixel needs its neighbours' samples.
SampleOffset sample_offset(const SamplingOptions&, int i, int j, int k);

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

/// Computes the picture at point (x, y) [pixels, as in CameraView]: fills `channels()` values. Called from many threads.
using SampleFunction = std::function<void(double x, double y, double* out)>;

/// Called once in each thread that helps; what it returns is called by that thread alone, so it may keep caches.
using SamplerFactory = std::function<SampleFunction()>;

/// Fills the film, in tiles over all threads. A layer "variance" with one channel is not the sampler's: it becomes the
/// estimated variance of the pixel's mean luminance in the beauty layer (0 with one sample), and its place in `out` is
/// passed over.
///
/// The picture is the same whatever the number of threads: a pixel's samples depend on its coordinates only and are
/// added in order. A crop has the pixels of the whole picture.
/// Throws ConvergenceError naming the pixel and the layer if a value is not finite; Cancelled.
void expose(Film&, const SamplingOptions&, const SamplerFactory&, const Progress& = {});

/// Rec. 709 luminance.
inline double luminance(double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }

}  // namespace vdbcloud
