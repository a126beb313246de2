// Light paths over a Lambertian ground: closed forms, slabs by adding and doubling, identities.
#include "render/path_estimates.h"
#include "render/periodic_scenes.h"
#include "support/slab_ground.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

/// A layer of optical depth tau and thickness 1 over a ground, lit by a sun of irradiance 1.
Scene layer_over_ground(double tau, double w0, double g, double mu0, double albedo)
{
    Scene scene;
    scene.volumes.push_back(volume_of(periodic_layer(8), medium(Vec3d(tau), Vec3d(w0), g)));
    scene.lights = {make_sun(Vec3d(std::sqrt(1 - mu0 * mu0), mu0, 0))};
    scene.periodic = xz;
    scene.ground = ground_beneath({scene.volumes[0].density.get()}, Vec3d(0, 1, 0), albedo);
    return scene;
}

/// A ray that comes down at the cosine mu, through a random place.
WorldRay from_above(double mu, int n)
{
    const double a = 2 * pi * uniform(hash_bits(4, uint64_t(n))), sine = std::sqrt(1 - mu * mu);
    const Vec3d w(sine * std::cos(a), -mu, sine * std::sin(a));
    return {Vec3d(3 * a, 0.4, 0) - 30 * w, w};
}

Vec3d everything(const RayResult& r) { return all_light(r) + r.ground; }
Vec3d of_ground(const RayResult& r) { return r.ground; }

TEST(PathGround, LiesWhereTheInterpolantEnds)
{
    // Voxels of 1/8 above y = 0: the lowest centres are at 0, so the interpolant ends at -1/8. Voxels of density 0 do
    // not count.
    const auto grid = periodic_layer(8);
    grid->tree().setValueOn(openvdb::Coord(3, -4, 3), 0.0f);
    const Ground ground = ground_beneath({grid.get()}, Vec3d(0, 1, 0), 0.5);
    EXPECT_NEAR(ground.height(Vec3d(7, -0.125, 3)), 0, 1e-12);
    EXPECT_NEAR(ground.height(Vec3d(7, 1, 3)), 1.125, 1e-12);
    EXPECT_NEAR(ground.distance({Vec3d(0, 0.875, 0), Vec3d(0.6, -0.8, 0)}), 1.25, 1e-12);
    EXPECT_TRUE(std::isinf(ground.distance({Vec3d(0, 1, 0), Vec3d(0.6, 0.8, 0)})));
    EXPECT_NEAR(ground_beneath({grid.get()}, Vec3d(0, 0, 1), 0.5).height(Vec3d(0)), 0.125, 1e-12);
    EXPECT_THROW(ground_beneath({grid.get()}, Vec3d(0, 1, 0), 1.5), InputError);
    EXPECT_THROW(require_light_above(make_sun(Vec3d(1, -0.1, 0)), ground), InputError);
    EXPECT_THROW(require_light_above(make_lamp(Vec3d(0, -0.2, 0)), ground), InputError);
    require_light_above(make_lamp(Vec3d(0, -0.1, 0)), ground);
}

TEST(PathGround, UnderClearAirShinesAsLambertSays)
{
    // No collisions, and the next event has no noise: each sample is A E cos / pi. A sky of radiance L adds A L.
    for (const double albedo : {0.0, 0.3, 1.0}) {
        Scene scene = layer_over_ground(0, 1, 0, 0.6, albedo);
        scene.lights.push_back(make_sun(Vec3d(0, 1, 0), Vec3d(0, 1, 2), 0, "zenith"));
        for (const double sky : {0.0, 0.5}) {
            scene.sky = Sky::constant(Vec3d(sky));
            const PathScene prepared(scene);
            PathTracer trace(prepared);
            RayResult r;
            for (int k = 0; k < 50; ++k) {
                trace(from_above(0.1 + 0.9 * k / 50, k), PathRandom(1, 0, 0, uint64_t(k)), r);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(r.ground[c], albedo * ((0.6 + c) / pi + sky), 1e-12) << albedo << " " << c;
                EXPECT_EQ(all_light(r), Vec3d(0.0));
                EXPECT_LT(r.to_ground, 1000);
            }
        }
    }
}

TEST(PathGround, WhiteFurnaceIsExactInEachSample)
{
    // A uniform sky over a white ground: the same radiance everywhere, in a medium without absorption.
    Scene scene = periodic_scene({}, Vec3d(0.5), 0.6);
    Volume& v = scene.volumes[0];
    v.collided = {};
    v.colour = v.emission = nullptr;
    v.medium.albedo = Vec3d(1.0);
    scene.lights.clear();
    scene.sky = Sky::constant(Vec3d(1, 2, 3));
    scene.ground = ground_beneath({v.density.get()}, Vec3d(0, 1, 0), 1);
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    int met = 0;
    for (int k = 0; k < 1000; ++k) {
        trace(from_above(0.05 + 0.95 * (k % 50) / 50, k), PathRandom(1, 0, 0, uint64_t(k)), r);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(everything(r)[c], c + 1, 1e-12) << k;
        met += r.ground[0] > 0;
    }
    EXPECT_EQ(met, 1000) << "the ground is a part of each";
}

TEST(PathGround, SlabMatchesAddingAndDoubling)
{
    const double tau = 1.5, w0 = 0.95, mu0 = 0.6;
    SlabExact::Options o{tau, w0, 0.6, mu0, {0.2, 0.9}, 20, {}};
    for (const double albedo : {0.3, 1.0}) {
        const SlabOverGround exact(o, albedo);
        const Scene scene = layer_over_ground(tau, w0, 0.6, mu0, albedo);
        for (size_t k = 0; k < 2; ++k) {
            const double mu = o.view[k];
            const auto ray = [&](int n) { return from_above(mu, n); };
            // The quadrature of the reference errs by 1e-4.
            const Estimate all = traced(scene, sized(2500, 400000), ray, everything);
            expect_mean(all, Vec3d(exact.radiance[k]), 0.05, Vec3d(1e-4 * exact.radiance[k]),
                        "albedo " + std::to_string(albedo) + " mu " + std::to_string(mu));
            const double seen = exact.ground * std::exp(-tau / mu);
            expect_mean(traced(scene, sized(2500, 400000), ray, of_ground), Vec3d(seen), 0.05, Vec3d(1e-4 * seen));
        }
    }
}

TEST(PathGround, AllLightComesBackWhereNothingAbsorbs)
{
    // pi times the mean radiance of rays that are distributed as a Lambertian surface's is the reflected power: mu0.
    for (const double tau : {1.0, 6.0}) {
        const Scene scene = layer_over_ground(tau, 1, 0.5, 0.6, 1);
        const Estimate up = traced(
            scene, sized(3500, 200000),
            [](int k) { return from_above(std::sqrt(1 - uniform(hash_bits(9, uint64_t(k)))), k); }, everything);
        expect_mean(up, Vec3d(0.6 / pi), 0.02, Vec3d(0.0), std::to_string(tau));
    }
}

/// Emission of a layer that is `radiance` times its density.
Vec3SGridPtr glow_of(const FloatGrid& density, const Vec3f& radiance)
{
    auto grid = Vec3SGrid::create(Vec3f(0));
    grid->setTransform(density.transform().copy());
    for (auto v = density.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), float(*v) * radiance);
    return grid;
}

TEST(PathGround, UnderAGlowingAbsorberShinesAsLambertSays)
{
    // B = j / sigma_t without scattering: B (1 - e^-tau/mu) from the layer, and from the ground its albedo times the
    // mean of the same over the cosines of a Lambertian surface, which reaches the eye with e^-tau/mu.
    const double tau = 1.5, mu = 0.6;
    const Vec3f b(1, 2, 0.5);
    for (const double albedo : {0.0, 0.3, 1.0}) {
        Scene scene = layer_over_ground(tau, 0, 0, 0.6, albedo);
        scene.lights.clear();
        scene.volumes[0].emission = glow_of(*scene.volumes[0].density, float(tau) * b);
        double down = 0;
        for (int k = 0; k < 2000; ++k) {
            const double x = (k + 0.5) / 2000;  // the cosine's square is even
            down -= std::expm1(-tau / std::sqrt(x)) / 2000;
        }
        const auto ray = [&](int n) { return from_above(mu, n); };
        const Vec3d seen = Vec3d(b) * (albedo * down * std::exp(-tau / mu)), own = Vec3d(b) * -std::expm1(-tau / mu);
        // The midpoint rule errs by 1e-4.
        expect_mean(traced(scene, sized(2500, 100000), ray, everything), seen + own, 0.05, 1e-4 * (seen + own),
                    std::to_string(albedo));
        if (albedo > 0) expect_mean(traced(scene, sized(2500, 100000), ray, of_ground), seen, 0.05, 1e-4 * seen);
    }
}

TEST(PathGround, KirchhoffsLawHoldsOverAWhiteGround)
{
    // Emission sigma_a B under a sky of radiance B: the radiance B in the mean, whatever scatters.
    Scene scene = layer_over_ground(2, 0.7, 0.5, 0.6, 1);
    scene.lights.clear();
    scene.volumes[0].emission = glow_of(*scene.volumes[0].density, Vec3f(0.6f));
    scene.sky = Sky::constant(Vec3d(1));
    expect_mean(
        traced(
            scene, sized(2500, 100000), [](int n) { return from_above(0.05 + 0.95 * (n % 50) / 50, n); }, everything),
        Vec3d(1), 0.03);
}

TEST(PathGround, ColouredMediaShareTheirPathsWithoutBias)
{
    // The three channels of one scene against three grey scenes.
    const Vec3d sigma_t(0.5, 1.5, 4);
    Scene scene = layer_over_ground(1, 0.95, 0.6, 0.6, 0.8);
    scene.volumes[0].medium.sigma_t_per_density = sigma_t;
    const Estimate all = traced(
        scene, sized(6000, 400000), [](int n) { return from_above(0.7, n); }, everything);
    SlabExact::Options o{1, 0.95, 0.6, 0.6, {0.7}, 20, {}};
    for (int c = 0; c < 3; ++c) {
        o.tau = sigma_t[c];
        const double expected = SlabOverGround(o, 0.8).radiance[0];
        EXPECT_NEAR(all.mean[c], expected, sigmas * all.error[c] + 1e-4 * expected) << c;
        EXPECT_LT(all.error[c], 0.05 * expected);
    }
}

TEST(PathGround, ThinAirAboveALampLitGroundScattersItsLight)
{
    // A thin blob at height h above the ground, straight below a lamp at height H: the fluence of the ground's light is
    // int (A / pi) I H / (H^2 + r^2)^(3/2) h / (h^2 + r^2)^(3/2) 2 pi r dr. Lamps are sampled in two ways beyond a
    // point of the ground, and both together are to be right.
    const double edge = 0.01, h = 0.5, H = 2, albedo = 0.7, sigma_t = 1e-2;
    Scene scene;
    scene.volumes.push_back(
        volume_of(box(Vec3i(1), edge, [](openvdb::Coord) { return 1.0; }), medium(Vec3d(sigma_t), Vec3d(1.0), 0)));
    scene.lights = {make_lamp(Vec3d(0, H - h, 0))};
    scene.ground = Ground{albedo, Vec3d(0, -h, 0), Vec3d(0, 1, 0)};
    double fluence = 0;
    const int parts = 4000;  // r = h tan a; the midpoint rule errs by 1e-6
    for (int k = 0; k < parts; ++k) {
        const double a = (k + 0.5) / parts * pi / 2, r = h * std::tan(a);
        fluence += pi / 2 / parts * 2 * albedo * H / std::pow(H * H + r * r, 1.5) * std::sin(a);
    }
    const WorldRay ray{Vec3d(-1, 0.001, 0.002), Vec3d(1, 0, 0)};
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    trace(ray, PathRandom(1, 0, 0, 0), r);
    const double expected = r.tau[0] * fluence / (4 * pi);
    EXPECT_GT(r.tau[0], 1e-5);
    // Beyond: light scattered twice in the blob, a share of its depth 1e-4.
    const auto multiple = [](const RayResult& sample) { return sample.multiple; };
    expect_mean(traced(scene, sized(20000, 400000), ray, multiple), Vec3d(expected), 0.03, Vec3d(2e-4 * expected));
}

TEST(PathGround, ThickAirAboveALampLitGroundIsTheSameFromBothWaysOfSampling)
{
    // A clump about a lamp that stands on the ground: reciprocity of lamp and camera does not hold for single pixels,
    // so the sum over the light's way is compared with the lamp moved into the sky: a lamp far away is a sun.
    Scene scene = one_clump(Vec3d(2), Vec3d(0.9), 0.5);
    scene.ground = ground_beneath({scene.volumes[0].density.get()}, Vec3d(0, 1, 0), 0.8);
    const Vec3d way = Vec3d(0.3, 1, 0.2).unit();
    const auto ray = [](int n) {
        return WorldRay{Vec3d(-5, 2.5 + 0.5 * uniform(hash_bits(5, uint64_t(n))), 0.1), Vec3d(1, -0.5, 0.02).unit()};
    };
    const int count = sized(10000, 400000);
    scene.lights = {make_sun(way)};
    const Estimate sun = traced(scene, count, ray, everything);
    const double far = 1e4;
    scene.lights = {make_lamp(far * way, Vec3d(far * far))};
    const Estimate lamp = traced(scene, count, ray, everything, 2);
    expect_equal(lamp, sun, 0.03);
}

TEST(PathGround, ABlackGroundChangesTheSkyFromBelowAlone)
{
    Scene scene = layer_over_ground(1, 0.9, 0.3, 0.6, 0);
    const auto ray = [](int n) { return from_above(0.5, n); };
    const auto samples = [&] {
        std::vector<Vec3d> all;
        traced(scene, 200, ray, [&](const RayResult& r) {
            all.push_back(everything(r));
            return all.back();
        });
        return all;
    };
    const auto black = samples();
    scene.ground.reset();
    EXPECT_EQ(samples(), black);
    scene.sky = Sky::constant(Vec3d(1.0));
    EXPECT_NE(samples(), black);
}

TEST(PathGround, ACameraBeneathSeesNothing)
{
    Scene scene = layer_over_ground(1, 0.9, 0.3, 0.6, 0.5);
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    for (const double up : {1.0, -1.0}) {
        trace({Vec3d(0, -1, 0), Vec3d(0, up, 0)}, PathRandom(1, 0, 0, 0), r);
        EXPECT_EQ(everything(r), Vec3d(0.0));
        EXPECT_EQ(r.to_ground, 0);
    }
}

}  // namespace
}  // namespace vdbcloud
