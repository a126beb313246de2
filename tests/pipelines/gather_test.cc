// Light paths that end in the picture without noise, on the cloud of puffs: their bias, and what they gain.
#include "pipelines/pictures.h"
#include "pipelines/solved_puffs.h"
#include "support/size.h"
#include "vdbcloud/render/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>

namespace vdbcloud {
namespace {

using namespace test;

double radiance(const RayResult& r) { return r.direct[0][0] + r.multiple[0]; }

struct Traced {
    Pictures pictures;
    double noise = 0;  ///< variance of a pixel's mean over the square of the picture's, times seconds
    double seconds = 0;
};

/// Pictures by paths of at most `vertices`; 0: whole paths.
Traced traced(const Scene& scene, int vertices, int samples)
{
    const PathScene prepared(scene);
    const PathEndScene end(scene);
    PathTracer trace(prepared, vertices > 0 ? &end : nullptr, vertices);
    RayResult r;
    Traced out;
    const std::clock_t start = std::clock();
    for (size_t v = 0; v < 3; ++v) {
        double variance = 0, all = 0;
        for (int i = 0; i < pixels; ++i)
            for (int j = 0; j < pixels; ++j) {
                double sum = 0, squares = 0;
                for (int k = 0; k < samples; ++k) {
                    PathRandom random(5, i + 100 * int(v), j, uint64_t(k));
                    const double x = random.next(), y = random.next();
                    trace(views[v].ray((i + x) / pixels, (j + y) / pixels), random, r);
                    sum += radiance(r);
                    squares += radiance(r) * radiance(r);
                }
                const double pixel = sum / samples;
                const double of_mean = std::max(0.0, squares / samples - pixel * pixel) / (samples - 1);
                Mean& block = out.pictures[v][size_t(i / edge * (pixels / edge) + j / edge)];
                block.value += pixel / (edge * edge);
                block.deviation = std::hypot(block.deviation, std::sqrt(of_mean) / (edge * edge));
                variance += of_mean;
                all += pixel;
            }
        out.noise += variance * pixels * pixels / (all * all) / 3;
    }
    out.seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    out.noise *= out.seconds;
    return out;
}

/// The picture without noise, 16 rays a pixel.
Pictures marched(const Scene& scene)
{
    const PreparedScene prepared(scene, {});
    const auto march = make_cells_integrator(prepared, {});
    RayResult r;
    Pictures pictures;
    constexpr int rays = 4;
    for (size_t v = 0; v < 3; ++v)
        for (int i = 0; i < rays * pixels; ++i)
            for (int j = 0; j < rays * pixels; ++j) {
                (*march)(views[v].ray((i + 0.5) / (rays * pixels), (j + 0.5) / (rays * pixels)), r);
                pictures[v][size_t(i / rays / edge * (pixels / edge) + j / rays / edge)].value +=
                    radiance(r) / (edge * edge * rays * rays);
            }
    return pictures;
}

TEST(Gather, EachCollisionTakesAPartOfTheErrorOfP1)
{
    // P1 alone errs by a fifth to a quarter over blocks. What remains is the error averaged over the directions of the
    // collisions, times their albedos, and times the chance to collide again. Noise: 1 % of a block at CI's size, which
    // adds 0.002 to the first ratio and 0.006 to the second.
    for (const auto& [w0, g, vertices, low, high] :
         {std::tuple(0.99, 0.0, 2, 0.66, 0.78), {0.99, 0.0, 4, 0.34, 0.47}, {1.0, 0.85, 2, 0.62, 0.80}}) {
        const Scene scene = solved_puffs(15, w0, g, 0);
        const Pictures truth = by_light_paths("puffs", 15, w0, g);
        const double without = rms(marched(scene), truth).value;
        const double with = rms(traced(scene, vertices, sized(32, 400)).pictures, truth).value;
        EXPECT_NEAR(without, 0.25, 0.05);
        EXPECT_GT(with, low * without) << g << ' ' << vertices;
        EXPECT_LT(with, high * without) << g << ' ' << vertices;
    }
}

TEST(Gather, NoiseIsBelowThatOfWholePaths)
{
    // At equal numbers of samples: time is not asserted.
    const Scene scene = solved_puffs(60, 1, 0.85, 3);
    const Traced two = traced(scene, 2, 32), whole = traced(scene, 0, 32);
    const double ratio = two.noise / two.seconds / (whole.noise / whole.seconds);
    EXPECT_LT(ratio, 0.3);
    EXPECT_GT(ratio, 0.01);
}

/// For docs/path.md: `make -C tests/bench gather`.
TEST(Gather, DISABLED_PrintsGainAndBias)
{
    std::printf(
        "| depth, albedo, g | vertices | mean from above, side, below | blocks | gain |\n|---|--:|--:|--:|--:|\n");
    for (const auto& [tau, w0, g] :
         {std::tuple(15.0, 0.99, 0.0), {60.0, 0.99, 0.0}, {15.0, 1.0, 0.85}, {60.0, 1.0, 0.85}}) {
        const Scene scene = solved_puffs(tau, w0, g, 3);
        const Pictures truth = by_light_paths("puffs", tau, w0, g);
        const int samples = g > 0 ? 1000 : 300;
        const double whole = traced(scene, 0, samples / 10).noise;
        for (const int vertices : {1, 2, 3, 4, 6, 10}) {
            Traced found;
            if (vertices > 1)
                found = traced(scene, vertices, samples);
            else
                found.pictures = marched(scene);
            std::printf("| %g, %g, %g | %d |", tau, w0, g, vertices);
            for (size_t v = 0; v < 3; ++v)
                std::printf("%s %+.1f +- %.1f", v ? "," : "",
                            100 * (mean(found.pictures[v]).value / mean(truth[v]).value - 1),
                            200 * std::hypot(mean(found.pictures[v]).deviation, mean(truth[v]).deviation) /
                                mean(truth[v]).value);
            std::printf(" %% | %.1f %% |", 100 * rms(found.pictures, truth).value);
            if (vertices > 1)
                std::printf(" %.1f |\n", whole / found.noise);
            else
                std::printf(" |\n");
        }
    }
}

}  // namespace
}  // namespace vdbcloud
