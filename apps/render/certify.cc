#include "certify.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/merge.h"
#include "vdbcloud/render/render_plan.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace vdbcloud {

namespace {

constexpr const char* not_covered =
    "not covered: what the density's voxels and the phase function chosen miss of a real medium";

std::string percent(double share)
{
    char text[32];
    const double x = 100 * share;
    std::snprintf(text, sizeof text, std::abs(x) < 0.1 ? "%.2f" : "%.1f", x);
    return text;
}

std::string seconds_text(double seconds)
{
    char text[32];
    std::snprintf(text, sizeof text, seconds < 10 ? "%.1f" : "%.0f", seconds);
    return text;
}

double half_width(const Interval& x) { return std::max(x.high - x.value, x.value - x.low); }

/// "error 1.8 +- 0.4 % rms over 32x32 pixels, mean -0.6 +- 0.2 %".
std::string sentence(const Certificate& c)
{
    const std::string error = c.coarse.low > 0
                                  ? "error " + percent(c.coarse.value) + " +- " + percent(half_width(c.coarse)) + " %"
                                  : "error below " + percent(c.coarse.high) + " %";
    return error + " rms over 32x32 pixels, mean " + (c.bias.value > 0 ? "+" : "") + percent(c.bias.value) + " +- " +
           percent(half_width(c.bias)) + " %";
}

std::string warning(const Certificate& c)
{
    return "one light path of " + std::to_string(c.samples) + " holds " + percent(c.heaviest) +
           " % of the noise: the intervals cannot be relied on; give --certify more time";
}

IntegratorOptions whole_paths()
{
    IntegratorOptions out;
    out.kind = Integrator::Path;
    return out;
}

nlohmann::json interval(const Interval& x) { return {{"value", x.value}, {"low", x.low}, {"high", x.high}}; }

/// A round number, 1, 2 or 5 times a power of ten, not below x.
double round_up(double x)
{
    const double power = std::pow(10, std::floor(std::log10(x)));
    for (const double step : {1.0, 2.0, 5.0})
        if (x <= step * power * (1 + 1e-9)) return step * power;
    return 10 * power;
}

/// White for no error; towards red above it, towards blue below. `x` in [-1, 1].
Vec3d false_colour(double x)
{
    const double a = std::min(1.0, std::abs(x));
    const Vec3d end = x > 0 ? Vec3d(0.70, 0.05, 0.10) : Vec3d(0.05, 0.20, 0.65), white(1, 1, 1);
    return a < 0.5 ? white + 2 * a * ((white + end) * 0.5 - white)
                   : (white + end) * 0.5 + (2 * a - 1) * (end - white) * 0.5;
}

}  // namespace

double certificate_bytes(const RenderOptions& o, const LoadedScene& loaded, const Film& film)
{
    return o.option.certify.given() ? render_bytes(film, loaded.scene, whole_paths()) : 0;
}

Workload certificate_work(const app::App& app, const RenderOptions& o, const LoadedScene& loaded, const Film& film,
                          const CameraView& view)
{
    if (!o.option.certify.given()) return {};
    const CertifyOptions options = certify_options(o);
    SamplingOptions sampling = o.sampling;
    sampling.samples = 1;
    const Film none(film.size(), render_layers(loaded.scene, {}, Integrator::Path));
    RenderCost cost = expected_cost(none, loaded.scene, view, sampling, whole_paths());
    const Workload work = render_work(none, loaded.scene, whole_paths(), cost);
    const double rays = std::max<double>(1, double(cost.rays));
    // Noise of a sample is about twice the mean; the error is taken to be four times the half-width asked for.
    double wanted = options.half_width > 0 ? 4 / (options.half_width * options.half_width) * 4 : HUGE_VAL;
    if (options.seconds > 0) {
        const double each = work.seconds() / rays;
        wanted = std::min(wanted, options.seconds * app.threads() / std::max(each, 1e-9));
    }
    cost.rays = uint64_t(wanted);
    cost.cells = uint64_t(double(cost.cells) * wanted / rays);
    return render_work(none, loaded.scene, whole_paths(), cost);
}

Certificate certify_picture(app::App& app, const RenderOptions& o, const LoadedScene& loaded, Film& film,
                            const CameraView& view)
{
    const std::clock_t start = std::clock();
    const Certificate c = [&] {
        const auto phase = app.phase("certify");
        return certify(film, loaded.scene, view, o.sampling, certify_options(o), app.progress("certify"));
    }();
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    app.add_work(render_work(film, loaded.scene, whole_paths(), c.cost));
    app.report()["certificate"] = {
        {"corrected", o.correct},      {"luminance", c.luminance},        {"mean", interval(c.bias)},
        {"rms_8x8", interval(c.fine)}, {"rms_32x32", interval(c.coarse)}, {"samples", c.samples},
        {"heaviest", c.heaviest},      {"reliable", c.reliable()},        {"reached", c.reached},
        {"cpu_seconds", seconds},      {"not_covered", not_covered}};
    app.say((o.correct ? "corrected picture: " : "") + sentence(c) + ", " + seconds_text(seconds) + " CPU s");
    app.say(not_covered);
    if (!c.reliable()) app.warnings()(warning(c));
    return c;
}

void stamp_certificate(ImageMetadata& to, const Certificate& c, bool corrected)
{
    to.texts.push_back({picture::certificate, (corrected ? "corrected picture: " : "") + sentence(c) +
                                                  (c.reliable() ? "" : "; " + warning(c)) + "; " + not_covered});
    const auto add = [&](const std::string& name, const Interval& x) {
        to.numbers.push_back({name, x.value});
        to.numbers.push_back({name + "_low", x.low});
        to.numbers.push_back({name + "_high", x.high});
    };
    add("vdbcloud:error_mean", c.bias);
    add("vdbcloud:error_8x8", c.fine);
    add("vdbcloud:error_32x32", c.coarse);
    to.numbers.push_back({"vdbcloud:certificate_samples", double(c.samples)});
}

void write_error_png(app::App& app, const RenderOptions& o, const Film& film, const Certificate& c,
                     const CameraView& view, const ImageMetadata& metadata)
{
    if (o.error_png.empty()) return;
    const double limit = round_up(std::max(0.01, 2 * c.fine.value));
    Film map(film.size(), {{"", {"R", "G", "B", "A"}, false}});
    const PixelWindow w = film.window();
    const int guess = film.offset(film.find("block_guess"));
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            const float* p = film.pixel(i, j);
            const bool seen = p[film.offset(film.find("block_deviation"))] > 0;
            const Vec3d colour = seen ? false_colour(p[guess] / (limit * c.luminance)) : Vec3d(0.5, 0.5, 0.5);
            for (int k = 0; k < 3; ++k) map.pixel(i, j)[k] = float(colour[k]);
            map.pixel(i, j)[3] = 1;
        }
    ImageOptions image;
    image.no_clobber = app.no_clobber();
    image.view.kind = ViewKind::None;
    write_image(o.error_png, map, view, metadata, image, app.warnings());
    app.report()["outputs"].push_back({{"path", o.error_png}});
    app.report()["certificate"]["error_png_limit"] = limit;
    app.say(o.error_png + ": red is " + percent(limit) +
            " % of the mean too bright, blue as much too dark, grey sees nothing");
}

void require_reached(const RenderOptions& o, const Certificate& c)
{
    if (c.reached) return;
    throw ConvergenceError("--certify " + printable(o.certify) + ": the error is known to " +
                           percent(half_width(c.coarse)) +
                           " % when the time ends; the picture is written. Give it more time");
}

}  // namespace vdbcloud
