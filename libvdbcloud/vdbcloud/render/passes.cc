#include "vdbcloud/render/passes.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/coarse_first.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

namespace vdbcloud {

namespace {

constexpr int tile = 16;               // pixels along the edge of what a thread takes at a time
constexpr int first_look = 16;         // samples before a noise target is looked at
constexpr uint64_t share_of_pass = 8;  // a pass adds one part in this many

double thread_seconds()
{
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Running mean and sum of squared deviations of a colour and of its luminance (Welford 1962).
struct Spread {
    Vec3d mean{0, 0, 0}, squares{0, 0, 0};
    double luminance_squares = 0;

    void add(const Vec3d& x, double count)
    {
        const Vec3d before = x - mean;
        mean += before / count;
        const Vec3d after = x - mean;
        squares += before * after;
        luminance_squares += luminance(before[0], before[1], before[2]) * luminance(after[0], after[1], after[2]);
    }
};

/// The sums of all pixels of a film's window.
class Passes {
public:
    Passes(Film& film, bool over_background) : film_(film), window_(film.window()), channels_(size_t(film.channels()))
    {
        const auto first = [&](const char* layer) {
            const int l = film.find(layer);
            return l < 0 ? -1 : film.offset(l);
        };
        beauty_ = first("");
        background_ = over_background ? first("background") : -1;
        error_ = first("standard_error");
        variance_ = first("variance");
        seconds_ = first("seconds");
        nearest_.assign(channels_, false);
        for (size_t l = 0; l < film.layers().size(); ++l)
            for (size_t c = 0; c < film.layers()[l].channels.size(); ++c)
                nearest_[size_t(film.offset(int(l))) + c] = film.layers()[l].combine == Combine::Nearest;
        const size_t pixels = size_t(window_.width()) * size_t(window_.height());
        sums_.assign(pixels * channels_, 0.0);
        spreads_.resize(pixels);
    }

    /// Adds samples first..first+count of every pixel; `done` were added before.
    void add(uint64_t first, uint64_t count, uint64_t done, tbb::enumerable_thread_specific<IndexedSample>& samplers,
             const std::function<void(double)>& tell)
    {
        const int across = (window_.width() + tile - 1) / tile, down = (window_.height() + tile - 1) / tile;
        std::atomic<int> tiles{0};
        tbb::parallel_for(0, across * down, [&](int t) {
            const IndexedSample& sample = samplers.local();
            const int x0 = window_.x0 + t % across * tile, y0 = window_.y0 + t / across * tile;
            for (int j = y0; j < std::min(y0 + tile, window_.y1); ++j)
                for (int i = x0; i < std::min(x0 + tile, window_.x1); ++i)
                    add_to_pixel(i, j, first, count, done, sample);
            tell(double(++tiles) / (across * down));
        });
    }

    /// Relative standard error of the luminance, from n samples a pixel.
    double noise(uint64_t n) const
    {
        if (n < 2) return 0;
        double mean = 0, variance = 0;
        for (const Spread& s : spreads_) {
            mean += luminance(s.mean[0], s.mean[1], s.mean[2]);
            variance += s.luminance_squares / (double(n) * double(n - 1));
        }
        const double pixels = double(spreads_.size());
        return mean > 0 ? std::sqrt(variance / pixels) / (mean / pixels) : 0;
    }

    void fill_film(uint64_t n)
    {
        const double squares = n > 1 ? 1 / (double(n) * double(n - 1)) : 0;
        for (int j = window_.y0; j < window_.y1; ++j)
            for (int i = window_.x0; i < window_.x1; ++i) {
                const size_t p = place(i, j);
                float* out = film_.pixel(i, j);
                for (size_t c = 0; c < channels_; ++c) {
                    const double sum = sums_[p * channels_ + c];
                    out[c] = float(nearest_[c] || int(c) == seconds_ ? sum : sum / double(n));
                }
                const Spread& s = spreads_[p];
                for (int c = 0; c < 3 && error_ >= 0; ++c) out[error_ + c] = float(std::sqrt(s.squares[c] * squares));
                if (variance_ >= 0) out[variance_] = float(s.luminance_squares * squares);
            }
    }

private:
    size_t place(int i, int j) const
    {
        return size_t(j - window_.y0) * size_t(window_.width()) + size_t(i - window_.x0);
    }

    void add_to_pixel(int i, int j, uint64_t first, uint64_t count, uint64_t done, const IndexedSample& sample)
    {
        const size_t p = place(i, j);
        double* sum = &sums_[p * channels_];
        const double start = seconds_ >= 0 ? thread_seconds() : 0;
        std::vector<double> value(channels_);
        for (uint64_t k = 0; k < count; ++k) {
            std::fill(value.begin(), value.end(), 0.0);
            sample(i, j, first + k, value.data());
            for (size_t c = 0; c < channels_; ++c) {
                if (!std::isfinite(float(value[c]))) refuse_value(film_, int(c), i, j, value[c]);
                if (nearest_[c])
                    sum[c] = done + k == 0 ? value[c] : std::min(sum[c], value[c]);
                else
                    sum[c] += value[c];
            }
            if (beauty_ < 0) continue;
            Vec3d seen(value[size_t(beauty_)], value[size_t(beauty_) + 1], value[size_t(beauty_) + 2]);
            for (int c = 0; c < 3 && background_ >= 0; ++c) seen[c] += value[size_t(background_ + c)];
            spreads_[p].add(seen, double(done + k + 1));
        }
        if (seconds_ >= 0) sum[seconds_] += thread_seconds() - start;
    }

    Film& film_;
    PixelWindow window_;
    size_t channels_;
    int beauty_, background_, error_, variance_, seconds_;
    std::vector<char> nearest_;
    std::vector<double> sums_;
    std::vector<Spread> spreads_;
};

void check(const PassOptions& o)
{
    if (!(o.time_limit >= 0)) throw InputError("time limit " + std::to_string(o.time_limit) + ": expected 0 or more");
    if (!(o.noise >= 0)) throw InputError("noise target " + std::to_string(o.noise) + ": expected 0 or more");
}

}  // namespace

PassReport expose_in_passes(Film& film, const SamplingOptions& sampling, const PassOptions& options,
                            const IndexedSampleFactory& factory, const Progress& progress)
{
    check(options);
    const double start = clock_seconds();
    const auto elapsed = [&] { return clock_seconds() - start; };
    Showing showing(options);
    tbb::enumerable_thread_specific<IndexedSample> samplers(factory);
    Passes passes(film, options.over_background);
    const uint64_t most = uint64_t(sampling.samples);
    const bool open = options.time_limit > 0 || options.noise > 0 || options.show;
    PassReport out;
    while (out.samples < most) {
        const uint64_t count =
            open ? std::min(most - out.samples, std::max<uint64_t>(1, out.samples / share_of_pass)) : most;
        const double before = out.noise;
        passes.add(options.offset + out.samples, count, out.samples, samplers, [&](double part) {
            double fraction = (double(out.samples) + part * double(count)) / double(most);
            if (options.time_limit > 0) fraction = std::max(fraction, std::min(1.0, elapsed() / options.time_limit));
            if (options.noise > 0 && before > options.noise)
                fraction = std::max(fraction, options.noise * options.noise / (before * before));
            report(progress, fraction);
        });
        out.samples += count;
        out.noise = passes.noise(out.samples);
        if (options.noise > 0 && out.samples >= first_look && out.noise <= options.noise) break;
        if (options.time_limit > 0 && elapsed() > options.time_limit) break;
        if (out.samples == most || !showing.due()) continue;
        passes.fill_film(out.samples);
        showing.show(film, {1, out.samples});
    }
    passes.fill_film(out.samples);
    return out;
}

}  // namespace vdbcloud
