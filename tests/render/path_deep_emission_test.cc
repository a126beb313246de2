// Emission behind deep matter and of small bodies, along light paths: what a path meets by chance too seldom.
#include "render/path_estimates.h"
#include "support/slab_exact.h"
#include "vdbcloud/optics/optical_depth.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

Vec3d emission_of(const RayResult& r) { return r.emission; }

/// Emission of the layer of voxels `j` of layer(n): 1 at their centres, falling linearly to 0 at the next centres.
Vec3SGridPtr glowing(const FloatGrid& layer, int j, const Vec3d& colour = Vec3d(1))
{
    auto grid = Vec3SGrid::create(Vec3f(0));
    grid->setTransform(layer.transform().copy());
    for (int x = 0; x < 8; ++x)
        for (int z = 0; z < 8; ++z) grid->tree().setValueOn({x, j, z}, Vec3f(colour));
    return grid;
}

/// The integral of a hat of height 1 and half width h times exp(-x y / h), y from its middle, over h.
double hat(double x) { return x == 0 ? 1 : 2 * (std::cosh(x) - 1) / (x * x); }

TEST(PathDeepEmission, BehindAnAbsorberIsItsClosedFormInEachSample)
{
    // 40 layers of density 1; the emitter is behind 20.5 of them. sigma_t 20: optical depth 10.25. Gauss's rule errs by
    // 1e-8 of the emission, float grids by 1e-7.
    constexpr int n = 40, j = 19;
    const double h = 1.0 / n, before = h / 2 + h * (n - 1 - j);
    for (const Vec3d& sigma_t : {Vec3d(20), Vec3d(5, 20, 60), Vec3d(0, 400, 1)}) {
        Scene scene;
        scene.volumes.push_back(volume_of(layer(n), medium(sigma_t, Vec3d(0), 0)));
        scene.volumes[0].emission = glowing(*scene.volumes[0].density, j, Vec3d(1, 2, 3));
        const Estimate e = traced(scene, 20, {Vec3d(0, 5, 0), Vec3d(0, -1, 0)}, emission_of);
        for (int c = 0; c < 3; ++c) {
            if (sigma_t[c] * before > 40) continue;
            const double expected = (c + 1) * h * std::exp(-sigma_t[c] * before) * hat(sigma_t[c] * h);
            EXPECT_NEAR(e.mean[c], expected, 3e-7 * expected) << sigma_t << c;
            EXPECT_LT(e.error[c], 1e-12 * expected) << sigma_t << c;
        }
    }
}

TEST(PathDeepEmission, OfOverlappingVolumesOfOtherVoxelsIsThatOfQuadrature)
{
    // Three media, two that emit, with voxels of their own. 20000 midpoints on 8 world units err by 1e-6: the
    // interpolants are continuous, and their kinks are not at the midpoints.
    Scene scene = one_clump(Vec3d(3, 5, 7), Vec3d(0.4), 0);
    const auto other = clump(14, 0.13, 5, Vec3d(0.3, 0.1, 0)), light = clump(9, 0.21, 7, Vec3d(-0.2, 0, 0.1));
    scene.volumes.push_back(volume_of(other, medium(Vec3d(6, 2, 0), Vec3d(0.4), 0)));
    const auto emitting = [](const FloatGrid& like, const Vec3f& colour) {
        auto grid = Vec3SGrid::create(Vec3f(0));
        grid->setTransform(like.transform().copy());
        for (auto v = like.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), *v * colour);
        return grid;
    };
    scene.volumes[0].emission = emitting(*light, Vec3f(1, 2, 3));
    scene.volumes[1].emission = emitting(*other, Vec3f(3, 1, 2));
    const auto at = [](const FloatGrid& grid, const Vec3d& x) {
        return trilinear(grid.getConstAccessor(), grid.transform().worldToIndex(x));
    };
    const WorldRay ray{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.5).unit()};
    constexpr int steps = 20000;
    const double dt = 8.0 / steps;
    Vec3d expected(0), tau(0);
    for (int k = 0; k < steps; ++k) {
        const Vec3d x = ray.at((k + 0.5) * dt);
        const double a = at(*scene.volumes[0].density, x), b = at(*other, x), l = at(*light, x);
        const Vec3d step = dt * (a * Vec3d(3, 5, 7) + b * Vec3d(6, 2, 0)),
                    emission = l * Vec3d(1, 2, 3) + b * Vec3d(3, 1, 2);
        expected += dt * emission * attenuation(tau + 0.5 * step);
        tau += step;
    }
    ASSERT_GT(tau[0], 2);
    ASSERT_GT(expected[0], 0.01);
    const Estimate e = traced(scene, 3, ray, emission_of);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(e.mean[c], expected[c], 3e-6 * expected[c]) << c;
        EXPECT_LT(e.error[c], 1e-12 * expected[c]) << c;
    }
}

TEST(PathDeepEmission, ThroughALayerThatScattersIsThatOfAddingAndDoubling)
{
    // A layer of optical depth 8 that emits at depth 6.8 alone, seen from above. By reciprocity the radiance is the
    // emission times the fluence that a beam of irradiance 1 along the ray makes there.
    constexpr int n = 48, j = 6;
    const double tau = 8, h = 1.0 / n, depth = tau * (h / 2 + h * (n - 1 - j)), across = tau * h;
    for (const double albedo : {0.8, 0.95}) {
        SlabExact::Options o;
        o.tau = tau;
        o.w0 = albedo;
        const SlabExact exact(o);
        // Simpson's rule on both halves of the hat: fluence falls by a fifth over a half.
        const auto fluence = [&](double at) { return exact.at(at).phi + std::exp(-at); };
        const double expected =
            h * (2 * fluence(depth - across / 2) + 2 * fluence(depth) + 2 * fluence(depth + across / 2)) / 6;
        Scene scene;
        scene.volumes.push_back(volume_of(layer(n), medium(Vec3d(tau), Vec3d(albedo), 0)));
        scene.volumes[0].emission = glowing(*scene.volumes[0].density, j);
        const Estimate e = traced(scene, sized(6000, 400000), {Vec3d(0, 5, 0), Vec3d(0, -1, 0)});
        expect_mean(e, Vec3d(expected), 0.06, Vec3d(1e-3 * expected), std::to_string(albedo));
    }
}

TEST(PathDeepEmission, OfASmallBodyLightsAsALamp)
{
    // A voxel of edge h that emits 1 at its centre emits the intensity h^3. The medium is 2 away: h^2 / distance^2, the
    // square of the body's size, is 1e-3. Paths that left the body to chance would meet it once in 10^5.
    const double h = 0.06;
    const Vec3d place(0.4, 2.6, 0.8);
    Scene scene = one_clump(Vec3d(3, 5, 9), Vec3d(0.9, 0.8, 0.7), 0.4);
    Scene lamp = scene;
    lamp.lights = {make_lamp(place, Vec3d(1, 2, 3) * (h * h * h))};
    auto body = Vec3SGrid::create(Vec3f(0));
    body->setTransform(openvdb::math::Transform::createLinearTransform(h));
    body->transform().postTranslate(place);
    body->tree().setValueOn({0, 0, 0}, Vec3f(1, 2, 3));
    scene.volumes[0].emission = body;
    const WorldRay ray{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.5).unit()};
    const Estimate found = traced(scene, sized(5000, 160000), ray),
                   expected = traced(lamp, sized(10000, 320000), ray, all_light, 2);
    expect_equal(found, expected, 0.04);
}

TEST(PathDeepEmission, OfASmallBodyDeepInAShieldLightsAsALamp)
{
    // Within a shield, a body of edge 0.1 mean free paths; the ray passes it at one mean free path. Light that was
    // scattered near the body is most of it, and paths from the camera seldom get there.
    const Vec3d place(2.03, 7.1, 6.9), eye(8, 7, 7);
    const double h = 0.1;
    Scene scene;
    scene.volumes.push_back(volume_of(box({28, 28, 28}, 0.5, [](openvdb::Coord) { return 1.0; }),
                                      medium(Vec3d(1, 1, 1.1), Vec3d(0.5), 0.3)));
    Scene lamp = scene;
    lamp.lights = {make_lamp(place, Vec3d(h * h * h))};
    auto body = Vec3SGrid::create(Vec3f(0));
    body->setTransform(openvdb::math::Transform::createLinearTransform(h));
    body->transform().postTranslate(place);
    body->tree().setValueOn({0, 0, 0}, Vec3f(1));
    scene.volumes[0].emission = body;
    const WorldRay ray{eye, (place + Vec3d(0, 1, 0.2) - eye).unit()};
    expect_equal(traced(scene, sized(6000, 160000), ray), traced(lamp, sized(10000, 320000), ray, all_light, 2),
                 sized(0.12, 0.05));
}

TEST(PathDeepEmission, RouletteKeepsTheMean)
{
    // Emission at optical depth 4.3: marches that end at random below a transmittance of 0.1 get there once in 7.
    Scene scene;
    scene.volumes.push_back(volume_of(layer(40), medium(Vec3d(5, 5.5, 6), Vec3d(0), 0)));
    scene.volumes[0].emission = glowing(*scene.volumes[0].density, 5, Vec3d(1, 2, 3));
    const PathScene prepared(scene);
    EmissionMarch march(prepared);
    PathMedia media(prepared);
    media.set({Vec3d(0, 5, 0), Vec3d(0, -1, 0)});
    const Vec3d expected = march.exact(media);
    const Estimate e = estimate(20000, [&](int k) {
        PathRandom random(1, 0, 0, uint64_t(k));
        return march.sampled(media, 0.1, random);
    });
    expect_mean(e, expected, 0.03);
    EXPECT_GT(e.error[0], 0.01 * expected[0]) << "marches end at random";
}

TEST(PathDeepEmission, KirchhoffsLawHoldsInTheMeanWhereEmissionIsSparse)
{
    // Two clouds far apart emit (1 - albedo) sigma_t B in a sky of radiance B: radiance B everywhere. Rays towards
    // emission and rays of the phase function meet the same emission.
    const Vec3d albedo(0.9, 0.5, 0.7), b(1, 2, 3), sigma_t(4, 5, 6);
    Scene scene = one_clump(sigma_t, albedo, 0.6);
    scene.volumes.push_back(volume_of(clump(14, 0.11, 3, Vec3d(5, 5, 5)), medium(sigma_t, albedo, 0.6)));
    for (Volume& volume : scene.volumes) {
        volume.emission = Vec3SGrid::create(Vec3f(0));
        volume.emission->setTransform(volume.density->transform().copy());
        for (auto v = volume.density->cbeginValueOn(); v; ++v)
            volume.emission->tree().setValueOn(v.getCoord(), Vec3f(*v * (Vec3d(1) - albedo) * sigma_t * b));
    }
    scene.sky = Sky::constant(b);
    ASSERT_TRUE(PathScene(scene).emission.sampled(Vec3d(0)));
    const WorldRay ray{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.5).unit()};
    const Estimate e = traced(scene, sized(3000, 80000), ray,
                              [&](const RayResult& r) { return r.multiple + r.emission + attenuation(r.tau) * b; });
    expect_mean(e, b, 0.02);
}

}  // namespace
}  // namespace vdbcloud
