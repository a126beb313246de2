// Scenes of several volumes: coefficients add, and each volume scatters the light that all volumes let through.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/light/transmittance_grid.h"

#include "render/pictures.h"
#include "support/moved.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

/// A body whose density falls smoothly to 0 at a distance of 9 voxels from the middle of 20^3.
FloatGridPtr puff(double skew = 0)
{
    return box({20, 20, 20}, 1, [&](Coord c) {
        const Vec3d p = (c.asVec3d() - Vec3d(9.5)) / 9;
        const double r = p.length();
        return r < 1 ? (1 - r * r) * (1 - r * r) * (1 + skew * p[0]) : 0.0;
    });
}

Scene scene_of(const std::vector<Volume>& volumes, const std::vector<Light>& lights)
{
    Scene scene;
    scene.volumes = volumes;
    scene.lights = lights;
    std::vector<CrossedMedium> media;
    for (const Volume& volume : volumes) media.push_back({volume.density, volume.medium});
    for (size_t v = 0; v < volumes.size(); ++v)
        for (const Light& light : lights)
            scene.volumes[v].transmittance.push_back(transmittance_grid(media, v, light, {}));
    return scene;
}

double direct(const Scene& scene, const CameraView& view, const IntegratorOptions& options, int c = 0)
{
    return Picture(scene, view, options).at("direct_" + scene.lights[0].name, c);
}

IntegratorOptions by_shadow_rays(Integrator kind)
{
    IntegratorOptions o = fine(kind);
    o.shadow_rays = true;
    return o;
}

TEST(SeveralVolumes, AVolumeInTheShadowOfAnotherIsDimmerByItsTransmittance)
{
    // A cube under a slab of optical depth 0.8, which is wider and is not on the ray.
    const Medium low = medium(Vec3d(0.1), Vec3d(0.9), 0.3), high = medium(Vec3d(0.08), Vec3d(0.7), -0.2);
    const auto slab = moved(box({40, 10, 40}, 1, [](Coord) { return 1.0; }), Vec3d(-12, 50, -12));
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0), Vec3d(2, 3, 5))};
    const Scene alone = scene_of({volume_of(cube(), low)}, sun),
                shaded = scene_of({volume_of(cube(), low), volume_of(slab, high)}, sun),
                other_order = scene_of({volume_of(slab, high), volume_of(cube(), low)}, sun);
    const auto view = one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(1, 0.2, 0.5)),
               above = one_pixel(Vec3d(7, 54, 8), Vec3d(1, 0, 0.3));
    const Scene slab_alone = scene_of({volume_of(slab, high)}, sun);
    for (const Integrator kind : integrators)
        for (int c = 0; c < 3; ++c) {
            const double full = direct(alone, view, fine(kind), c);
            EXPECT_GT(full, 0.02);
            // Grids of float exponentials; Romberg's tolerance is 1e-6 of the source.
            EXPECT_NEAR(direct(shaded, view, fine(kind), c) / full, std::exp(-0.8), 2e-5) << name(kind);
            EXPECT_NEAR(direct(other_order, view, fine(kind), c) / full, std::exp(-0.8), 2e-5) << name(kind);
            EXPECT_NEAR(direct(shaded, view, by_shadow_rays(kind), c) / full, std::exp(-0.8), 5e-4) << name(kind);
            EXPECT_NEAR(direct(shaded, above, fine(kind), c) / direct(slab_alone, above, fine(kind), c), 1, 1e-5);
        }
}

TEST(SeveralVolumes, OverlappingVolumesAreOneOfTheirSummedDensity)
{
    const Medium m = medium(Vec3d(0.06), Vec3d(0.95), 0.2);
    const auto a = puff(0.4), b = a->deepCopy(), sum = a->deepCopy();
    for (auto v = b->beginValueOn(); v; ++v) v.setValue(0.5f * *v + 0.02f * float(v.getCoord()[0]));
    for (auto v = sum->beginValueOn(); v; ++v) v.setValue(*v + b->tree().getValue(v.getCoord()));
    const std::vector<Light> lights{make_sun(Vec3d(0.3, 1, 0.2)), make_lamp(Vec3d(3, 30, 12))};
    const Scene one = scene_of({volume_of(sum, m)}, lights), two = scene_of({volume_of(a, m), volume_of(b, m)}, lights);
    for (const Integrator kind : integrators)
        for (const Vec3d& direction : {Vec3d(0.4, -0.3, 1), Vec3d(-1, 0.2, 0.1), Vec3d(0.1, 1, 0.3)}) {
            const auto view = one_pixel(Vec3d(8, 9, 11), direction);
            const Picture p(one, view, fine(kind)), q(two, view, fine(kind));
            for (const char* layer : {"direct_sun", "direct_lamp", "transmittance"})
                EXPECT_NEAR(q.at(layer, 0) / p.at(layer, 0), 1, 1e-4) << name(kind) << layer;  // depths are floats
        }
    // The second volume moved half a voxel is another medium: the sum must notice.
    const Scene shifted = scene_of({volume_of(a, m), volume_of(moved(b, Vec3d(0.5, 0, 0)), m)}, lights);
    const auto view = one_pixel(Vec3d(8, 9, 11), Vec3d(0.4, -0.3, 1));
    EXPECT_GT(std::abs(direct(shifted, view, fine(Integrator::Cells)) / direct(one, view, fine(Integrator::Cells)) - 1),
              1e-3);
}

/// A puff, a turned one of flat voxels that overlaps with the first, and a small dense one above both.
std::vector<Volume> three()
{
    return {volume_of(puff(0.3), medium(Vec3d(0.15), Vec3d(0.9, 0.8, 0.7), 0.3)),
            volume_of(moved(puff(), Vec3d(9, 6, 2), 0.7, Vec3d(0.7, 1.2, 0.8)), medium(Vec3d(0.2), Vec3d(0.5), 0.6)),
            volume_of(moved(puff(), Vec3d(5, 26, 4), -0.2, Vec3d(0.5)), medium(Vec3d(0.4), Vec3d(1), 0))};
}

TEST(SeveralVolumes, LightGridsAgreeWithShadowRaysOnAnyLattices)
{
    // The depth of the small body's shadow, 1.9 at most, curves by 0.5 a voxel^2 along both axes across the light.
    // Between the voxels of the bodies below it errs by 1/8 of that at the worst point, and by a sixth of the worst in
    // the mean.
    for (const Light& light :
         {make_sun(Vec3d(0.2, 1, -0.1), Vec3d(2, 3, 5)), make_lamp(Vec3d(12, 45, 7), Vec3d(900))}) {
        const Scene scene = scene_of(three(), {light});
        Scene single = scene;
        for (size_t v = 0; v < 3; ++v)
            single.volumes[v].transmittance = scene_of({three()[v]}, {light}).volumes[0].transmittance;
        double brightest = 0;
        for (const Vec3d& direction : {Vec3d(1, 0.1, 0.3), Vec3d(-0.3, 1, 0.2), Vec3d(0.1, -0.2, 1)})
            for (const Vec3d& target : {Vec3d(9, 8, 9), Vec3d(14, 12, 10)}) {
                const auto view = one_pixel(target, direction);
                for (const Integrator kind : integrators) {
                    const double grids = direct(scene, view, fine(kind)),
                                 rays = direct(scene, view, by_shadow_rays(kind));
                    EXPECT_NEAR(grids / rays, 1, 0.02) << name(kind) << light.name << target << direction;
                    brightest = std::max(brightest, direct(single, view, fine(kind)) / rays);
                }
            }
        EXPECT_GT(brightest, 1.2) << "each volume in its own shadow alone";
    }
}

TEST(SeveralVolumes, TheOrderOfVolumesDoesNotMatter)
{
    std::vector<Volume> volumes = three();
    const std::vector<Light> sun{make_sun(Vec3d(0.2, 1, -0.1))};
    const Scene first = scene_of(volumes, sun);
    std::rotate(volumes.begin(), volumes.begin() + 1, volumes.end());
    const Scene second = scene_of(volumes, sun);
    for (const Integrator kind : integrators) {
        const auto view = one_pixel(Vec3d(12, 10, 9), Vec3d(1, 0.1, 0.3));
        EXPECT_NEAR(direct(first, view, fine(kind)) / direct(second, view, fine(kind)), 1, 1e-5) << name(kind);
    }
}

TEST(SeveralVolumes, ALightGridCountsForItsOwnVolumeAlone)
{
    // Values of a light grid beyond the voxels of its volume mean nothing: replaced, they change nothing.
    const std::vector<Light> sun{make_sun(Vec3d(0.2, 1, -0.1))};
    Scene scene = scene_of(three(), sun);
    const auto view = one_pixel(Vec3d(12, 10, 9), Vec3d(1, 0.1, 0.3));
    std::vector<double> before;
    for (const Integrator kind : integrators) before.push_back(direct(scene, view, fine(kind)));
    for (Volume& volume : scene.volumes) {
        const auto grid = openvdb::gridPtrCast<FloatGrid>(volume.transmittance[0])->deepCopy();
        const auto box = grid->evalActiveVoxelBoundingBox();
        for (const Coord& ijk : openvdb::CoordBBox(box.min().offsetBy(-20), box.max().offsetBy(20)))
            if (!grid->tree().isValueOn(ijk)) grid->tree().setValueOn(ijk, 0.25f);
        volume.transmittance[0] = grid;
    }
    for (size_t k = 0; k < before.size(); ++k)
        EXPECT_NEAR(direct(scene, view, fine(integrators[k])) / before[k], 1, 1e-6) << name(integrators[k]);
}

TEST(SeveralVolumes, EmissionShinesThroughAllAndIsNotLit)
{
    // A flame without density behind a cube: the flame's light is attenuated by the cube, and the lights do not light
    // it.
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
    Volume flame = volume_of(FloatGrid::create(0.0f), medium(Vec3d(1), Vec3d(1), 0));
    flame.emission = constant_like<Vec3SGrid>(*cube(), Vec3f(1, 2, 3));
    auto behind = openvdb::math::Transform::createLinearTransform(1.0);
    behind->postTranslate(Vec3d(0, 0, -30));
    flame.emission->setTransform(behind);
    const Volume smoke = volume_of(cube(), medium(Vec3d(0.1), Vec3d(0.5), 0));
    const auto view = one_pixel(Vec3d(7.5, 7.5, 7.5), Vec3d(0, 0, -1));
    for (const Integrator kind : integrators) {
        const Picture both(scene_of({smoke, flame}, sun), view, fine(kind)),
            alone(scene_of({smoke}, sun), view, fine(kind));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(both.at("emission", c) / ((c + 1) * 16 * std::exp(-1.6)), 1, 2e-4) << name(kind);
        EXPECT_NEAR(both.at("direct_sun", 0) / alone.at("direct_sun", 0), 1, 2e-5) << name(kind);
    }
}

}  // namespace
}  // namespace vdbcloud
