// Light paths in media that repeat without end: identities, slabs and tilings.
#include "render/path_estimates.h"
#include "render/periodic_scenes.h"
#include "support/slab_exact.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

/// The scene without what light paths do not read.
Scene true_medium(const Tiles& tiles, const Vec3d& sigma_t, double albedo, double g)
{
    Scene scene = periodic_scene(tiles, sigma_t, g);
    Volume& v = scene.volumes[0];
    v.medium.albedo = Vec3d(albedo);
    v.collided = {};
    v.colour = nullptr;
    v.emission = nullptr;
    return scene;
}

/// A ray from above or below through a random place of a period, of random direction in its hemisphere, with the
/// density of mu.
WorldRay lambertian(int k, bool from_above, double width)
{
    const auto u = [&](uint64_t n) { return uniform(hash_bits(31, uint64_t(k), n)); };
    const double mu = std::sqrt(1 - u(0)), sine = std::sqrt(1 - mu * mu), a = 2 * pi * u(1);
    const Vec3d w(sine * std::cos(a), from_above ? -mu : mu, sine * std::sin(a));
    const Vec3d at(width * u(2), from_above ? 14 : -3, width * u(3));
    return {at - 3 * w / mu, w};
}

TEST(PathPeriodic, GreyFurnaceIsExactInEachSample)
{
    Scene scene = true_medium({}, Vec3d(0.5), 1, 0.6);
    scene.lights.clear();
    scene.sky = Sky::constant(Vec3d(1, 2, 3));
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    for (int k = 0; k < 1000; ++k) {
        const WorldRay ray = k % 3 == 2 ? WorldRay{Vec3d(3, 4 + k % 5, 9), Vec3d(1, 1e-3 * (k % 7), 0.2).unit()}
                                        : lambertian(k, k % 3 == 0, 16);
        trace(ray, PathRandom(1, 0, 0, uint64_t(k)), r);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.multiple[c] + std::exp(-r.tau[c]) * (c + 1), c + 1, 1e-12) << k;
    }
}

TEST(PathPeriodic, ReflectedAndTransmittedPowerOfALosslessFieldAddUpToWhatFalls)
{
    // Clumps with gaps, lit aslant: power of pi times the mean radiance of a Lambertian choice of rays.
    for (const double g : {0.0, 0.7}) {
        const Scene scene = true_medium({}, Vec3d(0.7), 1, g);
        const double mu0 = scene.lights[0].place()[1];
        const int count = sized(14000, 160000);
        const auto power = [&](bool above) {
            return traced(scene, count, [&](int k) { return lambertian(k, above, 16); });
        };
        const Estimate up = power(true), down = power(false);
        // The sun that passes: the mean over a period of exp(-tau).
        const Estimate passes = traced(
            scene, count,
            [&](int k) {
                const WorldRay ray = lambertian(k, true, 16);
                const Vec3d w = -scene.lights[0].place();
                return WorldRay{Vec3d(ray.at(3)[0], 14, ray.at(3)[2]) - 30 * w, w};
            },
            [](const RayResult& r) { return Vec3d(std::exp(-r.tau[0]), std::exp(-r.tau[1]), std::exp(-r.tau[2])); });
        for (int c = 0; c < 3; ++c) {
            const double E = scene.lights[0].strength()[c];
            const double sum = pi * (up.mean[c] + down.mean[c]) / (mu0 * E) + passes.mean[c];
            const double error = std::hypot(pi * std::hypot(up.error[c], down.error[c]) / (mu0 * E), passes.error[c]);
            EXPECT_NEAR(sum, 1, sigmas * error) << g;
            EXPECT_LT(error, 0.01);
            EXPECT_GT(pi * up.mean[c] / (mu0 * E), 0.05);
            EXPECT_GT(passes.mean[c], 0.05);
        }
    }
}

TEST(PathPeriodic, SlabMatchesAddingAndDoubling)
{
    const double tau = 2, w0 = 0.95, mu0 = 0.6;
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.6);
    SlabExact::Options o{tau, w0, 0, mu0, {0.1, 0.5, 0.95}, 32, {}};
    for (int l = 0; l < 64; ++l) o.moments.push_back(phase.moment(l));
    const SlabExact exact(o);
    Scene scene;
    scene.volumes.push_back(volume_of(periodic_layer(8), medium(Vec3d(tau), Vec3d(w0), 0.6)));
    scene.lights = {make_sun(Vec3d(std::sqrt(1 - mu0 * mu0), mu0, 0))};
    scene.periodic = xz;
    for (int k = 0; k < 3; ++k)
        for (const bool above : {true, false}) {
            const double mu = o.view[size_t(k)], sine = std::sqrt(1 - mu * mu);
            const auto ray = [&](int n) {
                const double a = 2 * pi * uniform(hash_bits(4, uint64_t(n)));
                const Vec3d w(sine * std::cos(a), above ? -mu : mu, sine * std::sin(a));
                return WorldRay{Vec3d(3 * a, 0.4, 0) - 30 * w, w};
            };
            const double expected = above ? exact.emergent_top(k) : exact.emergent_bottom(k);
            expect_mean(traced(scene, sized(7000, 160000), ray), Vec3d(expected), 0.05, Vec3d(1e-4 * expected),
                        (above ? "above " : "below ") + std::to_string(mu));
        }
}

TEST(PathPeriodic, ScatteredOnceIsThatOfCells)
{
    Scene scene = true_medium({}, Vec3d(0.2, 0.4, 0.8), 0.9, 0.5);
    IntegratorOptions how;
    how.shadow_rays = true;
    how.parts = 8;
    const PreparedScene prepared(scene, how);
    const auto cells = make_cells_integrator(prepared, how);
    Vec3d expected(0);
    RayResult r;
    for (int k = 0; k < 40; ++k) {
        (*cells)(lambertian(k, k % 2, 16), r);
        expected += scattered_once(r) / 40;
    }
    const Estimate e = traced(
        scene, 40 * 500, [](int k) { return lambertian(k % 40, k % 2, 16); }, scattered_once);
    expect_mean(e, expected, 0.09, 2e-4 * expected);
}

TEST(PathPeriodic, EmissionIsThatOfCells)
{
    for (const Vec3d& sigma_t : {Vec3d(0.4), Vec3d(0.2, 0.4, 0.8)}) {
        Scene scene = true_medium({}, sigma_t, 0, 0);
        scene.lights.clear();
        scene.volumes[0].emission = periodic_scene({}, sigma_t, 0).volumes[0].emission;
        IntegratorOptions how;
        how.shadow_rays = true;
        how.parts = 8;
        const PreparedScene prepared(scene, how);
        const auto cells = make_cells_integrator(prepared, how);
        Vec3d expected(0);
        RayResult r;
        for (int k = 0; k < 40; ++k) {
            (*cells)(lambertian(k, k % 2, 16), r);
            expected += r.emission / 40;
        }
        const Estimate e = traced(
            scene, 40 * 500, [](int k) { return lambertian(k % 40, k % 2, 16); },
            [](const RayResult& sample) { return sample.emission; });
        expect_mean(e, expected, 0.09, 2e-4 * expected);
    }
}

TEST(PathPeriodic, AFieldMovedAcrossItsSeamIsTheSame)
{
    const Vec3i shift(3, 0, -5);
    const int count = sized(18000, 160000);
    for (const double g : {0.0, 0.7}) {
        const Estimate still =
            traced(true_medium({}, Vec3d(0.5), 0.98, g), count, [](int k) { return lambertian(k % 50, k % 2, 16); });
        const Estimate moved = traced(
            true_medium({0, 0, true, shift}, Vec3d(0.5), 0.98, g), count,
            [&](int k) {
                const WorldRay ray = lambertian(k % 50, k % 2, 16);
                return WorldRay{ray.origin + Vec3d(shift), ray.direction};
            },
            all_light, 2);
        expect_equal(moved, still, 0.03, std::to_string(g));
    }
}

TEST(PathPeriodic, ATilingTendsToIt)
{
    // Near the middle of 7 x 7 copies; what leaves the sides and does not come back is below 1 %.
    const int count = sized(18000, 160000);
    const Estimate one =
        traced(true_medium({}, Vec3d(0.7), 0.9, 0.3), count, [](int k) { return lambertian(k % 50, k % 2, 16); });
    const Estimate many = traced(
        true_medium({-3, 3, false}, Vec3d(0.7), 0.9, 0.3), count, [](int k) { return lambertian(k % 50, k % 2, 16); },
        all_light, 2);
    expect_mean(many, one.mean, 0.03, one.error + 0.01 * one.mean);
    // And a single copy does not.
    const Estimate alone = traced(
        true_medium({0, 0, false}, Vec3d(0.7), 0.9, 0.3), count, [](int k) { return lambertian(k % 50, k % 2, 16); },
        all_light, 2);
    EXPECT_LT(alone.mean[0], 0.9 * one.mean[0]);
}

TEST(PathPeriodic, RaysWithinTheLayerEnd)
{
    Scene scene = true_medium({}, Vec3d(0.5), 1, 0.3);
    scene.volumes[0].emission = periodic_scene({}, Vec3d(0.5), 0).volumes[0].emission;
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    double light = 0;
    for (int k = 0; k < 200; ++k) {
        trace({Vec3d(3, 2 + 0.05 * k, 7), Vec3d(1, 0, 0.1 * (k % 3)).unit()}, PathRandom(1, 0, 0, uint64_t(k)), r);
        light += all_light(r)[0];
        EXPECT_TRUE(std::isfinite(light));
        EXPECT_GT(r.tau[0], 30);
    }
    EXPECT_GT(light / 200, 0.1);
}

}  // namespace
}  // namespace vdbcloud
