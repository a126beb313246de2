// What a picture would cost by a pilot of rays, against what a run counts.
#include "vdbcloud/render/render_plan.h"

#include "support/fields.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

Scene lumps(double sigma_t)
{
    Scene scene;
    Volume& volume = scene.volumes.emplace_back();
    volume.density = box({40, 40, 40}, 0.05, [](Coord p) {
        return std::max(0.0, std::sin(0.3 * p[0]) + std::sin(0.37 * p[1] + 1) + std::sin(0.41 * p[2] + 2) - 0.4);
    });
    volume.medium.sigma_t_per_density = Vec3d(sigma_t);
    volume.medium.albedo = Vec3d(0.9);
    return scene;
}

CameraView view(int width, int height, const PixelWindow& crop = {})
{
    Camera camera;
    camera.position = Vec3d(1, 1.2, 5);
    camera.look_at = Vec3d(1, 1, 1);
    return {camera, {width, height, 1, crop}};
}

/// What both say of one picture.
std::pair<RenderCost, RenderCost> said_and_taken(const Scene& scene, const CameraView& seen, const SamplingOptions& s,
                                                 const IntegratorOptions& o)
{
    Film film(seen.size(), render_layers(scene, {}, o.kind));
    const RenderCost said = expected_cost(film, scene, seen, s, o);
    return {said, render_image(film, scene, seen, s, o)};
}

TEST(RenderPlan, CountsCellsAndThoseThatAreNotHidden)
{
    // A thousand of 36000 rays, spread evenly: the count differs by the picture's detail between them.
    for (const double sigma_t : {1.0, 400.0}) {
        const Scene scene = lumps(sigma_t);
        const auto [said, taken] = said_and_taken(scene, view(240, 150), {}, {});
        EXPECT_EQ(said.rays, taken.rays);
        EXPECT_NEAR(double(said.cells) / double(taken.cells), 1, 0.05) << sigma_t;
        EXPECT_NEAR(double(said.lit) / double(taken.lit), 1, 0.05) << sigma_t;
        const double share = double(taken.lit) / double(taken.cells);
        EXPECT_EQ(share<0.8, sigma_t> 100) << share << ": opaque lumps hide some cells, thin ones none";
    }
}

TEST(RenderPlan, CountsSamplesAndAWindow)
{
    const Scene scene = lumps(5);
    SamplingOptions four;
    four.samples = 4;
    const auto [said, taken] = said_and_taken(scene, view(300, 300, {100, 120, 220, 200}), four, {});
    EXPECT_EQ(taken.rays, 4u * 120 * 80);
    EXPECT_EQ(said.rays, taken.rays);
    EXPECT_NEAR(double(said.cells) / double(taken.cells), 1, 0.1);
}

TEST(RenderPlan, CountsTheCollisionsOfLightPaths)
{
    // The pilot's 4096 paths: their lengths spread by about twice their mean, three standard errors are a tenth.
    Scene scene = lumps(8);
    scene.sky = Sky::constant(Vec3d(1.0));
    IntegratorOptions path;
    path.kind = Integrator::Path;
    SamplingOptions eight;
    eight.samples = 8;
    const auto [said, taken] = said_and_taken(scene, view(64, 64), eight, path);
    EXPECT_EQ(said.rays, taken.rays);
    EXPECT_NEAR(double(said.cells) / double(taken.cells), 1, 0.15);

    // The noise falls as the root of the samples: a pilot of four says when a target is met, within its own error.
    eight.samples = 4000;
    path.passes.noise = 0.2;
    const auto [until, met] = said_and_taken(scene, view(64, 64), eight, path);
    EXPECT_LT(met.passes.noise, 0.2);
    EXPECT_LT(met.passes.samples, 1000u);
    EXPECT_NEAR(double(until.rays) / double(met.rays), 1, 0.5);
}

TEST(RenderPlan, ChargesEachPathWithItsOwnEvents)
{
    Scene scene = lumps(5);
    const Film film(view(10, 10).size(), render_layers(scene, {}));
    RenderCost cost;
    cost.rays = 100;
    cost.cells = 3000;
    cost.lit = 2000;
    const Light sun = make_sun(Vec3d(0, 1, 0)), lamp = make_lamp(Vec3d(0, 9, 0));
    scene.lights = {sun, sun};
    const Workload plain = render_work(film, scene, {}, cost);
    EXPECT_EQ(plain.of("plain_cell"), 3000);
    EXPECT_EQ(plain.of("plain_light"), 4000);
    EXPECT_EQ(plain.of("cell"), 0);
    EXPECT_EQ(plain.of("film_value"), 100.0 * film.channels());

    scene.lights = {lamp};
    const Workload by_lamp = render_work(film, scene, {}, cost);
    EXPECT_EQ(by_lamp.of("plain_cell"), 0);
    EXPECT_EQ(by_lamp.of("cell"), 3000);
    EXPECT_EQ(by_lamp.of("cell_light"), 2000);
    EXPECT_EQ(by_lamp.of("cell_value"), 0);
    EXPECT_EQ(by_lamp.of("cell_peak"), 0);

    // Collided light of one channel: phi, three components of the flux and five moments.
    scene.lights = {sun};
    CollidedLight& collided = scene.volumes[0].collided;
    collided.phi = scene.volumes[0].density;
    collided.flux[0] = Vec3SGrid::create();
    collided.moments[0].assign(5, scene.volumes[0].density);
    collided.scaling.delta_f = 0.5;
    const Workload scaled = render_work(film, scene, {}, cost);
    EXPECT_EQ(scaled.of("plain_value"), 2000.0 * 9);
    EXPECT_EQ(scaled.of("plain_peak"), 2000);
    EXPECT_EQ(scaled.of("cell_value"), 0);
    IntegratorOptions general;
    general.plain_path = false;
    const Workload by_general = render_work(film, scene, general, cost);
    EXPECT_EQ(by_general.of("cell_value"), 2000.0 * 9);
    EXPECT_EQ(by_general.of("cell_peak"), 2000);
    EXPECT_EQ(scaled.of("brick_value") - by_lamp.of("brick_value"), by_lamp.of("brick_value") / 2 * 9);
}

}  // namespace
}  // namespace vdbcloud
