#include "vdbcloud/render/film.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/render/exposure.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>

namespace vdbcloud {

namespace {

constexpr int tile = 16;  // pixels along the edge of what a thread takes at a time

/// Running mean and spread of a pixel's luminance (Welford 1962).
struct Spread {
    double mean = 0, squares = 0;
    int count = 0;
    void add(double x)
    {
        const double before = x - mean;
        mean += before / ++count;
        squares += before * (x - mean);
    }
    double variance_of_mean() const { return count > 1 ? squares / (double(count - 1) * count) : 0; }
};

}  // namespace

Film::Film(const ImageSize& size, std::vector<LayerSpec> layers)
    : size_(size), window_(size.window()), layers_(std::move(layers))
{
    std::set<std::string> names;
    for (const LayerSpec& layer : layers_) {
        if (!names.insert(layer.name).second) throw InputError("film: two layers are called '" + layer.name + "'");
        if (layer.channels.empty()) throw InputError("film: layer '" + layer.name + "' has no channel");
        offsets_.push_back(channels_);
        channels_ += int(layer.channels.size());
    }
    data_.assign(size_t(window_.width()) * size_t(window_.height()) * size_t(channels_), 0.0f);
}

int Film::find(const std::string& layer) const
{
    for (size_t l = 0; l < layers_.size(); ++l)
        if (layers_[l].name == layer) return int(l);
    return -1;
}

const float* Film::pixel(int i, int j) const
{
    const size_t row = size_t(j - window_.y0), column = size_t(i - window_.x0);
    return data_.data() + (row * size_t(window_.width()) + column) * size_t(channels_);
}

float* Film::pixel(int i, int j) { return const_cast<float*>(std::as_const(*this).pixel(i, j)); }

void refuse_value(const Film& film, int channel, int i, int j, double value)
{
    size_t l = film.layers().size() - 1;
    while (film.offset(int(l)) > channel) --l;
    const LayerSpec& layer = film.layers()[l];
    throw ConvergenceError("pixel " + std::to_string(i) + "," + std::to_string(j) + ": layer '" +
                           (layer.name.empty() ? "beauty" : layer.name) + "' is " + shortest(value) +
                           ": expected a value that a float holds, as weaker lights give");
}

Exposure::Exposure(Film& film, const SamplingOptions& sampling)
    : film_(film), filter_(sampling), nearest_(size_t(film.channels()), false)
{
    for (size_t l = 0; l < film.layers().size(); ++l) {
        const LayerSpec& layer = film.layers()[l];
        const int first = film.offset(int(l));
        if (layer.name.empty() && layer.channels.size() >= 3) beauty_ = first;
        if (layer.name == "variance" && layer.channels.size() == 1) variance_ = first;
        for (size_t c = 0; c < layer.channels.size(); ++c)
            nearest_[size_t(first) + c] = layer.combine == Combine::Nearest;
    }
}

void Exposure::operator()(const SampleFunction& sample, int i, int j) const
{
    const auto n = size_t(film_.channels());
    std::vector<double> sum(n, 0.0), value(n);
    Spread spread;
    for (int k = 0; k < filter_.samples(); ++k) {
        const SampleOffset at = filter_(i, j, k);
        std::fill(value.begin(), value.end(), 0.0);
        sample(i + 0.5 + at.x, j + 0.5 + at.y, value.data());
        for (size_t c = 0; c < n; ++c) {
            if (!std::isfinite(float(value[c]))) refuse_value(film_, int(c), i, j, value[c]);
            if (nearest_[c])
                sum[c] = k == 0 ? value[c] : std::min(sum[c], value[c]);
            else
                sum[c] += value[c];
        }
        if (beauty_ >= 0 && variance_ >= 0) {
            const double* rgb = &value[size_t(beauty_)];
            spread.add(luminance(rgb[0], rgb[1], rgb[2]));
        }
    }
    float* out = film_.pixel(i, j);
    for (size_t c = 0; c < n; ++c) out[c] = float(nearest_[c] ? sum[c] : sum[c] / filter_.samples());
    if (variance_ >= 0) out[variance_] = float(spread.variance_of_mean());
}

void expose(Film& film, const SamplingOptions& sampling, const SamplerFactory& factory, const Progress& progress)
{
    const Exposure expose_pixel(film, sampling);
    const PixelWindow w = film.window();
    const int across = (w.width() + tile - 1) / tile, down = (w.height() + tile - 1) / tile;

    tbb::enumerable_thread_specific<SampleFunction> samplers(factory);
    std::atomic<int> done{0};
    tbb::parallel_for(0, across * down, [&](int t) {
        const SampleFunction& sample = samplers.local();
        const int x0 = w.x0 + t % across * tile, y0 = w.y0 + t / across * tile;
        for (int j = y0; j < std::min(y0 + tile, w.y1); ++j)
            for (int i = x0; i < std::min(x0 + tile, w.x1); ++i) expose_pixel(sample, i, j);
        report(progress, double(++done) / (across * down));
    });
}

}  // namespace vdbcloud
