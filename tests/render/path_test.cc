// Light paths against closed forms, exact solutions and independent estimates.
#include "render/path_estimates.h"
#include "support/monte_carlo.h"
#include "support/slab_exact.h"
#include "support/voxel_field.h"
#include "vdbcloud/optics/optical_depth.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

const WorldRay oblique{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.5).unit()};

/// A ray through the clumps of one_clump(), another for each k.
WorldRay crossing(int k)
{
    const Vec3d w = direction(uint64_t(k) + 77);
    Vec3d at;
    for (int a = 0; a < 3; ++a) at[a] = 1.2 * (uniform(hash_bits(9, uint64_t(k), uint64_t(a))) - 0.5);
    return {at - 5 * w, w};
}

std::vector<PhaseFunction> all_phases()
{
    return {PhaseFunction("isotropic"),
            PhaseFunction("rayleigh"),
            PhaseFunction::henyey_greenstein(0.85),
            PhaseFunction::henyey_greenstein(-0.5),
            PhaseFunction("double-henyey-greenstein", {0.8, -0.3, 0.7}),
            PhaseFunction("hg-draine", {10})};
}

TEST(Path, VacuumHasNoLightButTheSky)
{
    Scene scene = one_clump(Vec3d(0), Vec3d(1), 0);
    scene.sky = Sky::constant(Vec3d(1, 2, 3));
    scene.lights = {make_sun(Vec3d(0, 1, 0)), make_lamp(Vec3d(0, 0, 0))};
    const Estimate e = traced(scene, 10, oblique);
    EXPECT_EQ(e.mean, Vec3d(0));
    scene.volumes[0].density = FloatGrid::create(0.0f);
    scene.volumes[0].medium.sigma_t_per_density = Vec3d(1);
    EXPECT_EQ(traced(scene, 10, oblique).mean, Vec3d(0));
}

TEST(Path, TransmittanceIsThatOfTheInterpolant)
{
    const Scene scene = one_clump(Vec3d(2, 4, 8), Vec3d(0.5), 0);
    for (int k = 0; k < 5; ++k) {
        const double depth = integral_of_interpolant(*scene.volumes[0].density, crossing(k), 0, 10);
        ASSERT_GT(depth, 0.05);
        const Estimate tau = traced(scene, 2, crossing(k), [](const RayResult& r) { return r.tau; });
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(tau.mean[c], (2 << c) * depth, 1e-9 * depth);
    }
}

TEST(Path, GreyFurnaceIsExactInEachSample)
{
    for (const PhaseFunction& phase : all_phases()) {
        Scene scene = one_clump(Vec3d(12), Vec3d(1), 0);
        scene.volumes[0].medium.phase = phase;
        scene.volumes.push_back(volume_of(clump(12, 0.13, 5, Vec3d(0.3, 0, 0)), medium(Vec3d(5), Vec3d(1), 0.3)));
        scene.sky = Sky::constant(Vec3d(1, 2, 3));
        const PathScene prepared(scene);
        PathTracer trace(prepared);
        RayResult r;
        for (int k = 0; k < 300; ++k) {
            trace(crossing(k), PathRandom(1, 0, 0, uint64_t(k)), r);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(r.multiple[c] + std::exp(-r.tau[c]) * (c + 1), c + 1, 1e-12) << phase.text();
        }
    }
}

TEST(Path, ChromaticFurnaceIsExactInTheMeanWithBoundedSamples)
{
    Scene scene = one_clump(Vec3d(3, 6, 15), Vec3d(1), 0.6);
    scene.volumes.push_back(volume_of(clump(12, 0.13, 5, Vec3d(0.3, 0, 0)), medium(Vec3d(8, 0, 1), Vec3d(1), -0.3)));
    scene.sky = Sky::constant(Vec3d(1));
    double most = 0;
    const Estimate e = traced(scene, 30000, crossing, [&](const RayResult& r) {
        Vec3d sum = r.multiple;
        for (int c = 0; c < 3; ++c) sum[c] += std::exp(-r.tau[c]);
        most = std::max({most, sum[0], sum[1], sum[2]});
        return sum;
    });
    expect_mean(e, Vec3d(1), 0.01);
    EXPECT_LT(most, 4);  // three opacities and a transmittance
    EXPECT_GT(e.error[0] + e.error[1] + e.error[2], 1e-4);
}

/// Light scattered once, by the integrator of cells with a shadow ray at each point.
Vec3d scattered_once_by_cells(const Scene& scene, const WorldRay& ray)
{
    IntegratorOptions how;
    how.shadow_rays = true;
    how.parts = 8;
    const PreparedScene prepared(scene, how);
    RayResult r;
    (*make_cells_integrator(prepared, how))(ray, r);
    return scattered_once(r);
}

TEST(Path, DirectIsSingleScatteringByCells)
{
    // Cells in eighths err by 1e-4; the paths by 1 %.
    Scene grey = one_clump(Vec3d(9), Vec3d(0.9, 0.6, 0.3), 0.5);
    Scene coloured = one_clump(Vec3d(2, 5, 12), Vec3d(0.9, 0.6, 0.3), -0.3);
    Scene tinted = grey;
    tinted.volumes[0].colour = constant_like<Vec3SGrid>(*grey.volumes[0].density, Vec3f(0.9f, 0.5f, 0.1f));
    Scene two = coloured;
    two.volumes.push_back(volume_of(clump(16, 0.12, 5, Vec3d(0.2)), medium(Vec3d(4, 3, 0), Vec3d(1, 0.5, 0.5), 0.7)));
    for (Scene scene : {grey, coloured, tinted, two}) {
        for (const Light& light :
             {make_sun(Vec3d(0.3, 1, 0.2), Vec3d(2, 3, 5)), make_lamp(Vec3d(0.5, 2.5, 1), Vec3d(9))}) {
            scene.lights = {light};
            // The mean over 40 rays.
            Vec3d expected(0);
            for (int k = 0; k < 40; ++k) expected += scattered_once_by_cells(scene, crossing(k)) / 40;
            const Estimate e = traced(
                scene, 40 * 250, [](int k) { return crossing(k % 40); }, scattered_once);
            expect_mean(e, expected, 0.11, 2e-4 * expected, light.name);
        }
    }
}

TEST(Path, ASunsDiscLightsAsItsParts)
{
    // Looking into the sun, where the forward peak tells the disc's centre from its edge.
    Scene scene = one_clump(Vec3d(2), Vec3d(0.9), 0.7);
    const Vec3d to_sun = Vec3d(0.3, 1, 0.2).unit();
    const WorldRay ray{crossing(1).at(5) - 5 * to_sun, to_sun};
    const Light sun = make_sun(to_sun, Vec3d(2), 70);
    Vec3d expected(0);
    const Vec3d x = to_sun.cross(Vec3d(1, 0, 0)).unit(), y = to_sun.cross(x);
    constexpr int rings = 20, spokes = 20;  // midpoints of equal solid angles err by 2e-3
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < spokes; ++k) {
            const double c = 1 - (1 - std::cos(35 * pi / 180)) * (r + 0.5) / rings, s = std::sqrt(1 - c * c),
                         turn = 2 * pi * (k + 0.5) / spokes;
            scene.lights = {make_sun(c * to_sun + s * (std::cos(turn) * x + std::sin(turn) * y), Vec3d(2))};
            expected += scattered_once_by_cells(scene, ray) / (rings * spokes);
        }
    scene.lights = {make_sun(to_sun, Vec3d(2))};
    const Vec3d point = scattered_once_by_cells(scene, ray);
    scene.lights = {sun};
    expect_mean(traced(scene, 40000, ray, scattered_once), expected, 0.01, 2e-3 * expected);
    EXPECT_GT(std::abs(point[0] / expected[0] - 1), 0.3);  // the disc matters
}

struct Slab {
    double tau, w0, mu0;
    PhaseFunction phase;
};

TEST(Path, MatchesAddingAndDoublingOnSlabs)
{
    const Slab slabs[] = {{1, 1, 0.7, PhaseFunction("rayleigh")},
                          {4, 0.9, 0.5, PhaseFunction::henyey_greenstein(0.5)},
                          {4, 1, 0.9, PhaseFunction::henyey_greenstein(0.85)},
                          {9, 0.99, 0.6, PhaseFunction()},
                          {2, 0.95, 0.8, PhaseFunction("double-henyey-greenstein", {0.7, -0.3, 0.8})}};
    const std::vector<double> view{0.2, 0.6, 0.95};
    for (const Slab& s : slabs) {
        SlabExact::Options o{s.tau, s.w0, 0, s.mu0, view, 32, {}};
        for (int l = 0; l < 64; ++l) o.moments.push_back(s.phase.moment(l));
        const SlabExact exact(o);
        Scene scene;
        scene.volumes.push_back(volume_of(layer(), medium(Vec3d(s.tau), Vec3d(s.w0), 0)));
        scene.volumes[0].medium.phase = s.phase;
        scene.lights = {make_sun(Vec3d(std::sqrt(1 - s.mu0 * s.mu0), s.mu0, 0))};
        for (int k = 0; k < 3; ++k)
            for (const bool above : {true, false}) {
                const double mu = view[size_t(k)], sine = std::sqrt(1 - mu * mu);
                const auto ray = [&](int n) {  // of any azimuth
                    const double a = 2 * pi * uniform(hash_bits(4, uint64_t(n)));
                    const Vec3d w(sine * std::cos(a), above ? -mu : mu, sine * std::sin(a));
                    return WorldRay{Vec3d(0, 0.4, 0) - 30 * w, w};
                };
                const double expected = above ? exact.emergent_top(k) : exact.emergent_bottom(k);
                // The reference's own error: 64 moments, 32 nodes.
                expect_mean(traced(scene, sized(7000, 160000), ray), Vec3d(expected), 0.05, Vec3d(1e-4 * expected),
                            s.phase.text() + (above ? " above " : " below ") + std::to_string(mu));
            }
    }
}

TEST(Path, MatchesAnIndependentTracerOnTheCloudOfPuffs)
{
    const auto grid = voxel_field(Vec3i(24), Vec3d(1.0 / 24), [](const Vec3i& p) {
        double sum = 0;
        for (uint64_t k = 0; k < 8; ++k) {
            const Vec3d centre(0.25 + 0.5 * uniform(hash_bits(1, k)), 0.25 + 0.5 * uniform(hash_bits(2, k)),
                               0.25 + 0.5 * uniform(hash_bits(3, k)));
            const double d = ((Vec3d(p[0], p[1], p[2]) + Vec3d(0.5)) / 24 - centre).length() / 0.1;
            sum += std::exp(-d * d);
        }
        return sum > 0.15 ? sum - 0.1 : 0.0;
    });
    const BrickMap bricks(*grid);
    const int count = sized(18000, 200000);
    for (const auto& [w0, g] : {std::pair{0.99, 0.0}, {1.0, 0.85}, {0.9, 0.5}}) {
        Scene scene;
        scene.volumes.push_back(volume_of(grid, medium(Vec3d(25), Vec3d(w0), g)));
        scene.lights = {make_sun(Vec3d(0.3, 1, 0.2))};
        const McMedium plain{&bricks, 25, 8, w0, g, scene.lights[0].place()};
        for (const Vec3d& w : {Vec3d(0, -1, 0), Vec3d(0, 0, -1), Vec3d(0, 1, 0)}) {
            const auto ray = [&](int k) {
                const double u = uniform(hash_bits(7, uint64_t(k))), v = uniform(hash_bits(8, uint64_t(k)));
                return WorldRay{(w[1] == 0 ? Vec3d(u, v, 0.5) : Vec3d(u, 0.5, v)) - w, w};
            };
            const Estimate theirs =
                estimate(count, [&](int k) { return Vec3d(radiance_sample(plain, ray(k), 2.5, 11, uint64_t(k))); });
            expect_equal(traced(scene, count, ray), theirs, g > 0.8 ? 0.16 : 0.06, std::to_string(g));
        }
    }
}

/// The mean radiance over a disc of radius 2 about the origin, seen along `view`.
Estimate seen(Scene scene, const Vec3d& view, const Vec3d& to_sun, int count)
{
    scene.lights = {make_sun(to_sun)};
    const Vec3d w = view.unit(), x = (std::abs(w[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(w).unit(),
                y = w.cross(x);
    return traced(scene, count, [&](int k) {
        const double r = 2 * std::sqrt(uniform(hash_bits(5, uint64_t(k)))),
                     a = 2 * pi * uniform(hash_bits(6, uint64_t(k)));
        return WorldRay{r * std::cos(a) * x + r * std::sin(a) * y - 5 * w, w};
    });
}

TEST(Path, ReciprocityOfSunAndCamera)
{
    // Power from the sun's direction into the camera's is that of the exchanged directions.
    Scene scene = one_clump(Vec3d(4, 8, 12), Vec3d(0.95), 0.6);
    scene.volumes.push_back(volume_of(clump(12, 0.13, 5, Vec3d(0.3, 0, 0)), medium(Vec3d(5), Vec3d(1), -0.4)));
    const Vec3d a = Vec3d(0.2, 1, 0.3).unit(), b = Vec3d(1, -0.3, 0.4).unit();
    const int count = sized(26000, 400000);
    expect_equal(seen(scene, -a, b, count), seen(scene, -b, a, count), 0.04);
}

TEST(Path, TwoVolumesAreOneOfAddedDensity)
{
    const auto first = clump(20, 0.1, 1), second = clump(20, 0.1, 2);
    auto both = clump(20, 0.1, 1);
    for (auto v = both->beginValueOn(); v; ++v)
        v.setValue(first->tree().getValue(v.getCoord()) + second->tree().getValue(v.getCoord()));
    for (const Vec3d& sigma_t : {Vec3d(8), Vec3d(3, 6, 12)}) {
        const Medium m = medium(sigma_t, Vec3d(0.95), 0.6);
        Scene two, one;
        two.volumes = {volume_of(first, m), volume_of(second, m)};
        one.volumes = {volume_of(both, m)};
        for (Scene* scene : {&two, &one}) {
            scene->lights = {make_sun(Vec3d(0.3, 1, 0.2)), make_lamp(Vec3d(0.1, 0.2, 0.1), Vec3d(0.3))};
            scene->sky = Sky::constant(Vec3d(0.1));
        }
        const int count = sized(14000, 200000);
        expect_equal(traced(two, count, crossing, all_light, 1), traced(one, count, crossing, all_light, 2), 0.03);
    }
}

TEST(Path, ColoursAreThreeGreyRuns)
{
    const Vec3d sigma_t(2, 6, 15), albedo(0.9, 0.98, 0.8);
    const int count = sized(14000, 200000);
    Scene scene = one_clump(sigma_t, albedo, 0.6);
    scene.lights = {make_sun(Vec3d(0.3, 1, 0.2), Vec3d(1, 2, 3)), make_lamp(Vec3d(0.1, 0.2, 0.1), Vec3d(0.3))};
    scene.sky = Sky::constant(Vec3d(0.3, 0.2, 0.1));
    const Estimate colour = traced(scene, count, crossing);
    for (int c = 0; c < 3; ++c) {
        scene.volumes[0].medium = medium(Vec3d(sigma_t[c]), Vec3d(albedo[c]), 0.6);
        const Estimate grey = traced(scene, count, crossing, all_light, 2);
        const double error = std::hypot(colour.error[c], grey.error[c]);
        EXPECT_NEAR(colour.mean[c], grey.mean[c], sigmas * error);
        EXPECT_LT(error, 0.03 * grey.mean[c]);
    }
}

TEST(Path, TurnedAndMirroredGridsShowTheSame)
{
    // Voxels of three different edges, in a grid that is turned and mirrored together with sun, lamp and rays.
    Scene scene = one_clump(Vec3d(8), Vec3d(0.97), 0.7);
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m.postTranslate(openvdb::Vec3d(-9.5));
    m.postScale(openvdb::Vec3d(0.08, 0.1, 0.13));
    scene.volumes[0].density->setTransform(openvdb::math::Transform::createLinearTransform(m));
    scene.lights = {make_sun(Vec3d(0.3, 1, 0.2)), make_lamp(Vec3d(0.1, 0.2, 0.1), Vec3d(0.3))};
    Scene other = scene;
    other.volumes[0].density = scene.volumes[0].density->deepCopy();
    m.postRotate(openvdb::math::Y_AXIS, 0.7);
    m.postRotate(openvdb::math::X_AXIS, -0.4);
    m.postScale(openvdb::Vec3d(1, 1, -1));
    other.volumes[0].density->setTransform(openvdb::math::Transform::createLinearTransform(m));
    openvdb::Mat4d turn = openvdb::Mat4d::identity();
    turn.postRotate(openvdb::math::Y_AXIS, 0.7);
    turn.postRotate(openvdb::math::X_AXIS, -0.4);
    turn.postScale(openvdb::Vec3d(1, 1, -1));
    other.lights = {make_sun(turn.transform(Vec3d(0.3, 1, 0.2))),
                    make_lamp(turn.transform(Vec3d(0.1, 0.2, 0.1)), Vec3d(0.3))};
    const auto turned = [&](int k) {
        return WorldRay{turn.transform(crossing(k).origin), turn.transform(crossing(k).direction)};
    };
    const int count = sized(14000, 200000);
    expect_equal(traced(other, count, turned), traced(scene, count, crossing, all_light, 2), 0.03);
}

TEST(Path, SkyOfAnyShapeLightsAsManySuns)
{
    // A sky of suns on a Fibonacci lattice, each of its solid angle; scattered once, in a thin medium.
    Scene scene = one_clump(Vec3d(0.003), Vec3d(0.5), 0.3);
    const Sky sky = GradientSky{Vec3d(0.2, 0.4, 1), Vec3d(1, 0.8, 0.6), Vec3d(0.3, 0.1, 0), 2, Vec3d(1, 2, 2)};
    Vec3d expected(0);
    constexpr int suns = 300;
    for (int n = 0; n < suns; ++n) {
        const double z = 1 - 2 * (n + 0.5) / suns, a = golden_angle * n, s = std::sqrt(1 - z * z);
        const Vec3d to(s * std::cos(a), z, s * std::sin(a));
        scene.lights = {make_sun(to, sky.radiance(to) * (4 * pi / suns))};
        expected += scattered_once_by_cells(scene, crossing(1));
    }
    scene.lights.clear();
    scene.sky = sky;
    // Suns and lattice agree to 1e-3; what is scattered twice is a share of less than half the opacity.
    const Estimate e = traced(scene, 20000, crossing(1));
    expect_mean(e, expected, 0.01, 1e-3 * expected);
    EXPECT_LT(traced(scene, 1, crossing(1), [](const RayResult& r) { return r.tau; }).mean[0], 0.003);
}

}  // namespace
}  // namespace vdbcloud
