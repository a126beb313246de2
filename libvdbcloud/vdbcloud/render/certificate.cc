#include "vdbcloud/render/certificate.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/block_errors.h"
#include "vdbcloud/render/correction.h"
#include "vdbcloud/render/path.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr uint64_t own_seed = 0x6365727469667921;  // of streams that no picture's samples have
constexpr uint64_t fewest_passes = 8, first_look = 16;
constexpr int most_samples_a_block = 16;    // in a pass
constexpr double samples_a_pass = 1 << 14;  // about

double luminance_of(const Vec3d& x) { return luminance(x[0], x[1], x[2]); }

/// A picture and samples of its truth.
class Comparison {
public:
    Comparison(const Film& picture, const Scene& scene, const CameraView& view, const SamplingOptions& sampling)
        : picture_(picture), view_(view), sky_(scene.sky), scene_(scene), filter_(sampling), seed_(sampling.seed),
          blocks(picture, BlockErrors::edge), errors(blocks.across, blocks.down, weights()), tracers_([this] {
              return Tracer{PathTracer(scene_), RayResult()};
          })
    {
        beauty_ = picture.offset(picture.find(""));
        const int sky = picture.find("sky"), background = picture.find("background");
        behind_ = sky_.dark() ? -1 : picture.offset(sky >= 0 ? sky : background);
        choose_counts();
    }

    /// Mean luminance of the picture over the pixels that count.
    double picture_luminance() const { return mean_; }

    /// One pass over all blocks.
    void add(uint64_t pass, const Progress& progress)
    {
        std::atomic<size_t> done{0};
        const size_t count = blocks.pixels.size();
        std::vector<double> squares(count), largest(count);
        tbb::parallel_for(size_t(0), count, [&](size_t b) {
            if (blocks.pixels[b].empty()) return;
            errors.add(b, pass, one_block(b, pass, squares[b], largest[b]));
            if (++done % 64 == 0) report(progress, double(done) / double(count));
        });
        for (size_t b = 0; b < count; ++b) {
            squares_ += squares[b];
            largest_ = std::max(largest_, largest[b]);
        }
    }

    double heaviest() const { return squares_ > 0 ? largest_ / squares_ : 0; }
    RenderCost cost() const
    {
        RenderCost out;
        out.rays = rays_;
        out.cells = collisions_;
        return out;
    }

private:
    struct Tracer {
        PathTracer trace;
        RayResult result;
    };

    std::vector<double> weights() const
    {
        std::vector<double> out;
        for (const auto& pixels : blocks.pixels) out.push_back(double(pixels.size()));
        return out;
    }

    Vec3d shown(int i, int j) const
    {
        const float* p = picture_.pixel(i, j);
        Vec3d out(p[beauty_], p[beauty_ + 1], p[beauty_ + 2]);
        for (int c = 0; c < 3 && behind_ >= 0; ++c) out[c] += p[behind_ + c];
        return out;
    }

    /// Samples of each block in a pass: in proportion to its light, as the noise of light paths is.
    void choose_counts()
    {
        const size_t count = blocks.pixels.size();
        std::vector<double> light(count);
        double pixels = 0, sum = 0;
        size_t seen = 0;
        for (size_t b = 0; b < count; ++b) {
            for (const auto& [i, j] : blocks.pixels[b]) light[b] += luminance_of(shown(i, j));
            sum += light[b];
            pixels += double(blocks.pixels[b].size());
            seen += !blocks.pixels[b].empty();
        }
        if (seen == 0 || !(sum > 0))
            throw InputError("the picture shows no light that could be compared with the truth");
        mean_ = sum / pixels;
        const double most = std::clamp(samples_a_pass / double(seen), 1.0, double(most_samples_a_block) / 2);
        for (size_t b = 0; b < count; ++b)
            counts_.push_back(
                std::clamp(int(std::lround(most * light[b] * double(seen) / sum)), 1, most_samples_a_block));
    }

    Vec3d one_block(size_t b, uint64_t pass, double& squares, double& largest)
    {
        Tracer& tracer = tracers_.local();
        const auto& pixels = blocks.pixels[b];
        const int x = int(b % size_t(blocks.across)) + blocks.x0, y = int(b / size_t(blocks.across)) + blocks.y0;
        Vec3d sum(0, 0, 0);
        uint64_t collisions = 0;
        for (int s = 0; s < counts_[b]; ++s) {
            PathRandom random(hash_bits(own_seed, seed_), x, y, pass * most_samples_a_block + uint64_t(s));
            const double share = (s + random.next()) / counts_[b];
            const auto& [i, j] = pixels[std::min(pixels.size() - 1, size_t(share * double(pixels.size())))];
            const double u = random.next(), v = random.next();
            const WorldRay ray =
                view_.ray(i + 0.5 + filter_.inverse_cumulative(u), j + 0.5 + filter_.inverse_cumulative(v));
            tracer.trace(ray, random, tracer.result);
            const Vec3d error = shown(i, j) - seen(tracer.result, ray, i, j);
            collisions += tracer.result.cells;
            sum += error;
            const double part = luminance_of(error) / counts_[b], square = double(pixels.size()) * part * part;
            squares += square;
            largest = std::max(largest, square);
        }
        rays_ += uint64_t(counts_[b]);
        collisions_ += collisions;
        return sum / counts_[b];
    }

    Vec3d seen(const RayResult& r, const WorldRay& ray, int i, int j) const
    {
        Vec3d sum = r.multiple + r.emission + r.ground + r.solid;
        for (const Vec3d& direct : r.direct) sum += direct;
        if (!sky_.dark() && !(r.to_ground < 1e30)) sum += attenuation(r.tau) * sky_.radiance(ray.direction);
        for (int c = 0; c < 3; ++c)
            if (!std::isfinite(sum[c])) refuse_value(picture_, beauty_ + c, i, j, sum[c]);
        return sum;
    }

    const Film& picture_;
    const CameraView& view_;
    const Sky& sky_;
    const PathScene scene_;
    const PixelFilter filter_;
    uint64_t seed_;
    int beauty_ = 0, behind_ = -1;
    double mean_ = 0, squares_ = 0, largest_ = 0;
    std::vector<int> counts_;
    std::atomic<uint64_t> rays_{0}, collisions_{0};

public:
    const PixelBlocks blocks;
    BlockErrors errors;

private:
    tbb::enumerable_thread_specific<Tracer> tracers_;
};

Interval root(const Interval& square, double unit)
{
    const auto of = [&](double x) { return std::sqrt(std::max(0.0, x)) / unit; };
    return {of(square.value), of(square.low), of(square.high)};
}

Interval middle(const Interval& a, const Interval& b)
{
    return {(a.value + b.value) / 2, (a.low + b.low) / 2, (a.high + b.high) / 2};
}

/// Errors in the picture's unit: of the mean; mean squares over fine and coarse blocks.
struct Figures {
    Interval bias, fine, coarse;
};

Figures figures(const BlockErrors& errors, uint64_t passes, const BatchPart& part, const std::vector<Vec3d>& known)
{
    const int batches = BlockErrors::count(passes, part);
    const auto fine = errors.fine(passes, part, known);
    return {mean_error(fine, batches), mean_square_error(fine, batches),
            mean_square_error(errors.coarse_blocks(passes, part, known), batches)};
}

/// Those of the corrected picture: each half of the batches judges the correction by the other half.
Figures corrected_figures(const Film& picture, const Comparison& comparison, uint64_t passes)
{
    Figures half[2];
    for (int h = 0; h < 2; ++h) {
        const Correction correction(picture, comparison.blocks, comparison.errors.shrunk(passes, {h, 2}));
        half[h] = figures(comparison.errors, passes, {1 - h, 2}, correction.taken());
    }
    return {middle(half[0].bias, half[1].bias), middle(half[0].fine, half[1].fine),
            middle(half[0].coarse, half[1].coarse)};
}

Certificate certificate_of(const Film& picture, const Comparison& comparison, uint64_t passes, bool correct)
{
    const Figures plain = figures(comparison.errors, passes, {}, {});
    const Figures all = correct ? corrected_figures(picture, comparison, passes) : plain;
    Certificate out;
    out.luminance = comparison.picture_luminance() - plain.bias.value;
    if (!(out.luminance > 0)) throw ConvergenceError("light paths find no light to compare the picture with");
    out.bias = {all.bias.value / out.luminance, all.bias.low / out.luminance, all.bias.high / out.luminance};
    out.fine = root(all.fine, out.luminance);
    out.coarse = root(all.coarse, out.luminance);
    out.passes = passes;
    return out;
}

double half_width(const Interval& x) { return std::max(x.high - x.value, x.value - x.low); }

void show_errors(Film& picture, const Comparison& comparison, uint64_t passes)
{
    const auto place = [&](const char* layer) { return picture.offset(picture.find(layer)); };
    const int error = place("block_error"), deviation = place("block_deviation"), guess = place("block_guess");
    const auto guesses = comparison.errors.shrunk(passes);
    for (size_t b = 0; b < comparison.blocks.pixels.size(); ++b) {
        if (comparison.blocks.pixels[b].empty()) continue;
        const Vec3d mean = comparison.errors.mean(b, passes);
        const double spread = std::sqrt(comparison.errors.variance(b, passes));
        for (const auto& [i, j] : comparison.blocks.pixels[b]) {
            float* p = picture.pixel(i, j);
            for (int c = 0; c < 3; ++c) p[error + c] = float(mean[c]);
            p[deviation] = float(spread);
            p[guess] = float(luminance_of(guesses[b]));
        }
    }
}

void correct_picture(Film& picture, const Comparison& comparison, uint64_t passes)
{
    const Correction correction(picture, comparison.blocks, comparison.errors.shrunk(passes));
    const PixelWindow w = picture.window();
    const int beauty = picture.offset(picture.find("")), layer = picture.find("correction");
    std::vector<Vec3d> changes;
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) changes.push_back(correction.at(i, j));
    size_t n = 0;
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i, ++n)
            for (int c = 0; c < 3; ++c) {
                picture.pixel(i, j)[beauty + c] += float(changes[n][c]);
                if (layer >= 0) picture.pixel(i, j)[picture.offset(layer) + c] = float(changes[n][c]);
            }
}

}  // namespace

std::vector<LayerSpec> certificate_layers(const Scene& scene, bool correct)
{
    const std::vector<std::string> rgb{"R", "G", "B"};
    std::vector<LayerSpec> out;
    if (!scene.sky.dark() && !(scene.sky == scene.background)) out.push_back({"sky", rgb, false, Combine::Mean, false});
    out.push_back({"block_error", rgb, false});
    out.push_back({"block_deviation", {"Y"}, false});
    out.push_back({"block_guess", {"Y"}, false, Combine::Mean, false});
    if (correct) out.push_back({"correction", rgb, false});
    return out;
}

Certificate certify(Film& picture, const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                    const CertifyOptions& options, const Progress& progress)
{
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
    Comparison comparison(picture, scene, view, sampling);
    uint64_t passes = 0, look = first_look;
    Certificate out;
    for (;;) {
        comparison.add(passes++, [&](double part) {
            const double least = (double(passes - 1) + part) / double(fewest_passes);
            const double time = options.seconds > 0 ? elapsed() / options.seconds : 1;
            if (progress) return progress(std::min({1.0, least, time}));
            return true;
        });
        if (passes < fewest_passes) continue;
        if (options.half_width > 0 && passes == look) {
            out = certificate_of(picture, comparison, passes, options.correct);
            if (half_width(out.coarse) <= options.half_width) break;
            look += look / 4;
        }
        if (options.seconds > 0 && elapsed() > options.seconds) break;
        if (options.passes > 0 ? passes >= options.passes : !(options.seconds > 0) && !(options.half_width > 0)) break;
    }
    out = certificate_of(picture, comparison, passes, options.correct);
    out.reached = !(options.half_width > 0) || half_width(out.coarse) <= options.half_width;
    out.heaviest = comparison.heaviest();
    out.cost = comparison.cost();
    out.samples = out.cost.rays;
    show_errors(picture, comparison, passes);
    if (options.correct) correct_picture(picture, comparison, passes);
    return out;
}

}  // namespace vdbcloud
