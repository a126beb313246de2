// Pictures by samples: errors, parts of one run, threads, limits.
#include "render/path_estimates.h"

#include <tbb/global_control.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

constexpr int n = 6;

Scene lit()
{
    Scene scene = one_clump(Vec3d(4, 8, 12), Vec3d(0.95), 0.6);
    scene.lights = {make_sun(Vec3d(0.3, 1, 0.2))};
    scene.sky = scene.background = Sky::constant(Vec3d(0.1, 0.2, 0.3));
    return scene;
}

CameraView view()
{
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.position = Vec3d(0, 0, 9);
    camera.width = 2.4;
    ImageSize size;
    size.width = size.height = n;
    return {camera, size};
}

struct Rendering {
    Film film;
    RenderCost cost;
};

Rendering run(int samples, const PassOptions& passes = {}, const Scene& scene = lit(), uint64_t seed = 0)
{
    Rendering out{Film(view().size(), render_layers(scene, {"all"}, Integrator::Path)), {}};
    SamplingOptions sampling;
    sampling.samples = samples;
    sampling.seed = seed;
    IntegratorOptions how;
    how.kind = Integrator::Path;
    how.passes = passes;
    out.cost = render_image(out.film, scene, view(), sampling, how);
    return out;
}

bool same(const Film& a, const Film& b)
{
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            if (!std::equal(a.pixel(i, j), a.pixel(i, j) + a.channels(), b.pixel(i, j))) return false;
    return true;
}

TEST(Passes, ThreadsDoNotChangeThePicture)
{
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Rendering serial = run(8);
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
    EXPECT_TRUE(same(serial.film, run(8).film));
    EXPECT_FALSE(same(serial.film, run(8, {}, lit(), 1).film));
}

TEST(Passes, PassesDoNotChangeThePicture)
{
    PassOptions in_passes;
    in_passes.time_limit = 1e6;
    const Rendering passes = run(37, in_passes);
    EXPECT_EQ(passes.cost.passes.samples, 37u);
    EXPECT_TRUE(same(passes.film, run(37).film));
}

TEST(Passes, PartsOfDisjointOffsetsAreOneRun)
{
    PassOptions later;
    later.offset = 10;
    const Film whole = run(30).film, first = run(10).film, second = run(20, later).film;
    const int error = whole.offset(whole.find("standard_error"));
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) {
                const double a = first.pixel(i, j)[c], b = second.pixel(i, j)[c], mean = (10 * a + 20 * b) / 30;
                EXPECT_NEAR(whole.pixel(i, j)[c], mean, 1e-6 * mean + 1e-9);
                const double ea = first.pixel(i, j)[error + c], eb = second.pixel(i, j)[error + c];
                const double squares = ea * ea * 90 + eb * eb * 380 + (a - b) * (a - b) * 200 / 30;
                EXPECT_NEAR(whole.pixel(i, j)[error + c], std::sqrt(squares / 870),
                            1e-5 * whole.pixel(i, j)[error + c] + 1e-9);
            }
    EXPECT_FALSE(same(first, run(10, later).film));
}

TEST(Passes, StandardErrorIsThatOfTheMeans)
{
    // 100 runs of 16 samples: the variance of their means against the mean square of the error they tell. The variance
    // of so many pixels' 100 values has a relative standard error of about sqrt(2 / 99 / 20), pixels being unequal.
    double told = 0, found = 0, noise = 0;
    std::vector<double> sum(n * n, 0.0), squares(n * n, 0.0);
    constexpr int runs = 100;
    for (int r = 0; r < runs; ++r) {
        PassOptions part;
        part.offset = uint64_t(r) * 16;
        const Rendering one = run(16, part);
        const int error = one.film.offset(one.film.find("standard_error"));
        for (int p = 0; p < n * n; ++p) {
            const float* pixel = one.film.pixel(p % n, p / n);
            told += pixel[error] * pixel[error] / runs;
            sum[size_t(p)] += pixel[0];
            squares[size_t(p)] += double(pixel[0]) * pixel[0];
        }
        noise += one.cost.passes.noise / runs;
    }
    for (int p = 0; p < n * n; ++p) found += (squares[size_t(p)] - sum[size_t(p)] * sum[size_t(p)] / runs) / (runs - 1);
    EXPECT_NEAR(told / found, 1, 0.15);
    EXPECT_GT(noise, 0);
}

TEST(Passes, NoiseTargetIsReachedAndNotByFar)
{
    PassOptions target;
    target.noise = 0.05;
    const Rendering one = run(100000, target);
    EXPECT_LE(one.cost.passes.noise, 0.05);
    EXPECT_GT(one.cost.passes.noise, 0.05 / 1.15);  // passes grow by an eighth
    EXPECT_GE(one.cost.passes.samples, 16u);
    EXPECT_LT(one.cost.passes.samples, 100000u);
    // The noise again, from the layers.
    double mean = 0, variance = 0;
    const int v = one.film.offset(one.film.find("variance"));
    for (int p = 0; p < n * n; ++p) {
        const float* pixel = one.film.pixel(p % n, p / n);
        mean += luminance(pixel[0], pixel[1], pixel[2]) / (n * n);
        variance += pixel[v] / (n * n);
    }
    EXPECT_NEAR(std::sqrt(variance) / mean, one.cost.passes.noise, 1e-4 * one.cost.passes.noise);
}

TEST(Passes, ATimeLimitEndsTheRun)
{
    PassOptions limit;
    limit.time_limit = 0.05;
    const Rendering one = run(most_samples, limit);
    EXPECT_GE(one.cost.passes.samples, 1u);
    EXPECT_LT(one.cost.passes.samples, uint64_t(most_samples));
    EXPECT_EQ(one.cost.rays, one.cost.passes.samples * n * n);
}

TEST(Passes, LayersAddUpAndAreFloats)
{
    const Scene scene = lit();
    const Film film = run(8).film;
    const auto at = [&](const char* layer) { return film.offset(film.find(layer)); };
    for (const LayerSpec& layer : film.layers()) EXPECT_FALSE(layer.half) << layer.name;
    EXPECT_EQ(film.find("seconds"), -1);  // not in "all": it depends on the clock
    double light = 0;
    for (int p = 0; p < n * n; ++p) {
        const float* pixel = film.pixel(p % n, p / n);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(pixel[c],
                        pixel[at("direct_sun") + c] + pixel[at("multiscatter") + c] + pixel[at("emission") + c],
                        1e-6 * pixel[c]);
            light += pixel[at("multiscatter") + c];
            EXPECT_NEAR(pixel[at("background") + c], pixel[at("transmittance") + c] * 0.1 * (c + 1), 1e-6);
        }
        const float* t = pixel + at("transmittance");
        EXPECT_NEAR(pixel[3], 1 - (t[0] + t[1] + t[2]) / 3, 1e-6);
    }
    EXPECT_GT(light, 0);
}

TEST(Passes, DepthIsThatOfCells)
{
    // Within a cube that fills the picture the depth is the same everywhere, so a pixel's samples agree.
    Scene scene;
    scene.volumes = {volume_of(cube(0.25), medium(Vec3d(1, 2, 3), Vec3d(0.9), 0))};
    scene.volumes[0].density->transform().postTranslate(Vec3d(-2, -2, 0));
    Film path(view().size(), render_layers(scene, {"Z"}, Integrator::Path));
    IntegratorOptions how;
    how.kind = Integrator::Path;
    SamplingOptions sampling;
    sampling.samples = 4;
    render_image(path, scene, view(), sampling, how);
    Film cells(view().size(), render_layers(scene, {"Z"}));
    how = {};
    how.shadow_rays = true;
    render_image(cells, scene, view(), {}, how);
    for (int p = 0; p < n * n; ++p) {
        const float a = path.pixel(p % n, p / n)[path.offset(path.find("Z"))],
                    b = cells.pixel(p % n, p / n)[cells.offset(cells.find("Z"))];
        EXPECT_NEAR(a, b, 1e-5);
        EXPECT_LT(b, 9);
        EXPECT_GT(b, 5);
    }
}

TEST(Passes, SecondsAreMeasuredWhenAskedFor)
{
    const Scene scene = lit();
    Film film(view().size(), render_layers(scene, {"seconds"}, Integrator::Path));
    IntegratorOptions how;
    how.kind = Integrator::Path;
    SamplingOptions sampling;
    sampling.samples = 64;
    render_image(film, scene, view(), sampling, how);
    double seconds = 0;
    for (int p = 0; p < n * n; ++p) seconds += film.pixel(p % n, p / n)[film.offset(film.find("seconds"))];
    EXPECT_GT(seconds, 1e-5);
    EXPECT_LT(seconds, 100);
}

}  // namespace
}  // namespace vdbcloud
