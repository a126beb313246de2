// Light paths that end in the picture of the other integrators, against closed forms and whole paths.
#include "render/path_estimates.h"
#include "support/voxel_field.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <cmath>
#include <string>

namespace vdbcloud {
namespace {

using namespace test;

/// As if p1solve had found one fluence everywhere.
void solve_as(Volume& volume, double fluence, int degree = 1)
{
    volume.collided.phi = constant_like<FloatGrid>(*volume.density, float(fluence));
    volume.collided.scaling = delta_scaling(volume.medium.phase, degree);
}

template<typename Check>
void each_sample(const Scene& scene, int vertices, int count, const std::function<WorldRay(int)>& ray,
                 const Check& check)
{
    const PathScene prepared(scene);
    const PathEndScene end(scene);
    PathTracer trace(prepared, &end, vertices);
    RayResult r;
    for (int k = 0; k < count; ++k) {
        trace(ray(k), PathRandom(1, 0, 0, uint64_t(k)), r);
        check(r);
    }
}

Estimate gathered(const Scene& scene, int vertices, int count, const WorldRay& ray, const Part& part)
{
    const PathScene prepared(scene);
    const PathEndScene end(scene);
    PathTracer trace(prepared, &end, vertices);
    RayResult r;
    return estimate(count, [&](int k) {
        trace(ray, PathRandom(1, 3, 4, uint64_t(k)), r);
        return part(r);
    });
}

WorldRay crossing(int k)
{
    const Vec3d w = direction(uint64_t(k) + 77);
    return {0.3 * direction(uint64_t(k) + 991) - 5 * w, w};
}

TEST(PathGather, GreyFurnaceIsExactInEachSample)
{
    // A sky of radiance 2 has the fluence 8 pi in matter that absorbs nothing, in the scaled medium as in the true one.
    // The march integrates a constant source without error but its rounding.
    for (const double g : {0.0, 0.85, -0.4})
        for (const int vertices : {2, 3, 7}) {
            Scene scene = one_clump(Vec3d(12), Vec3d(1), g);
            scene.sky = Sky::constant(Vec3d(2));
            solve_as(scene.volumes[0], 8 * pi);
            int ends = 0;
            each_sample(scene, vertices, 200, crossing, [&](const RayResult& r) {
                EXPECT_NEAR(r.multiple[0] + 2 * std::exp(-r.tau[0]), 2, 1e-5) << g << ' ' << vertices;
                ends += int(r.ends);
            });
            EXPECT_GT(ends, 50);
        }
}

TEST(PathGather, ErrorOfTheSolutionFadesWithEachCollision)
{
    // From the middle of opaque matter nothing is seen but the source function of the solution, w0' phi / (4 pi), times
    // the albedo of each collision before.
    const WorldRay from_within{Vec3d(7.5), Vec3d(0.6, 0, 0.8)};
    for (const double g : {0.0, 0.7})
        for (const int vertices : {2, 3, 5}) {
            Scene scene;
            const double w = 0.9;
            scene.volumes.push_back(volume_of(cube(), medium(Vec3d(9), Vec3d(w), g)));
            solve_as(scene.volumes[0], 4 * pi);
            const double last = scene.volumes[0].collided.scaling.albedo(w);
            each_sample(
                scene, vertices, 50, [&](int) { return from_within; },
                [&](const RayResult& r) {
                    EXPECT_NEAR(r.multiple[0], std::pow(w, vertices - 1) * last, 1e-5) << g << ' ' << vertices;
                });
            // Three channels share paths: exact in the mean.
            const Vec3d albedo(0.9, 0.8, 0.6);
            scene.volumes[0] = volume_of(cube(), medium(Vec3d(9, 12, 15), albedo, g));
            solve_as(scene.volumes[0], 4 * pi);
            Vec3d expected;
            for (int c = 0; c < 3; ++c)
                expected[c] = std::pow(albedo[c], vertices - 1) * scene.volumes[0].collided.scaling.albedo(albedo[c]);
            expect_mean(gathered(scene, vertices, 4000, from_within, [](const RayResult& r) { return r.multiple; }),
                        expected, 0.02);
        }
}

/// Dark matter about a lamp and a ball that glows, and a sun; no light is scattered often.
Scene dark_scene(double albedo)
{
    Scene scene = one_clump(Vec3d(4), Vec3d(albedo), 0.4);
    Volume& volume = scene.volumes[0];
    scene.lights = {make_sun(Vec3d(0.3, 1, 0.2)), make_lamp(Vec3d(0.21, 0.13, -0.32), Vec3d(3))};
    TransmittanceOptions exact;
    exact.fidelity = Fidelity::Exact;
    exact.error_samples = 0;
    for (const Light& light : scene.lights)
        volume.transmittance.push_back(transmittance_grid(*volume.density, volume.medium, light, exact));
    return scene;
}

TEST(PathGather, TwoVerticesAreTwoOrdersOfScattering)
{
    // Without a solution's light, paths of two vertices bring the second order alone. Orders above it are at most the
    // albedo of it. Light grids interpolate depth between voxels of 0.4 mean free paths: 1 % of second order.
    const double albedo = 0.03;
    Scene scene = dark_scene(albedo);
    solve_as(scene.volumes[0], 0);
    const WorldRay ray{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.2).unit()};
    for (const char* source : {"sun", "lamp", "emission"}) {
        Scene one = scene;
        Volume& volume = one.volumes[0];
        if (source == std::string("emission")) {
            one.lights.clear();
            volume.transmittance.clear();
            volume.emission = Vec3SGrid::create(Vec3f(0));
            volume.emission->setTransform(volume.density->transform().copy());
            // Aside from the ray: directions to it are sampled from most collisions, and met by chance from few.
            volume.emission->tree().setValueOn({14, 4, 12}, Vec3f(100));
        } else {
            const size_t other = source == std::string("sun") ? 1 : 0;
            one.lights.erase(one.lights.begin() + std::ptrdiff_t(other));
            volume.transmittance.erase(volume.transmittance.begin() + std::ptrdiff_t(other));
        }
        const Part part = [](const RayResult& r) { return r.multiple; };
        const int count = sized(30000, 200000);
        const Estimate found = gathered(one, 2, count, ray, part), whole = traced(one, count, ray, part);
        const double noise = sigmas * std::hypot(found.error[0], whole.error[0]);
        EXPECT_LT(noise, sized(0.2, 0.06) * whole.mean[0]) << source;
        EXPECT_LT(found.mean[0], 1.01 * whole.mean[0] + noise) << source;
        EXPECT_GT(found.mean[0], (0.99 - albedo) * whole.mean[0] - noise) << source;
    }
}

TEST(PathGather, MediumWithoutSolutionIsRefused)
{
    const Scene scene = one_clump(Vec3d(4), Vec3d(0.9), 0);
    EXPECT_THROW(PathEndScene{scene}, InputError);
    Film film(one_pixel(Vec3d(0), Vec3d(1, 0, 0)).size(), render_layers(scene, {}, Integrator::Path));
    IntegratorOptions options;
    options.kind = Integrator::Path;
    options.vertices = 1;
    EXPECT_THROW(render_image(film, scene, one_pixel(Vec3d(0), Vec3d(1, 0, 0)), {}, options), InputError);
}

}  // namespace
}  // namespace vdbcloud
