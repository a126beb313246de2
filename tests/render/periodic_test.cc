// Media that repeat without end, seen by the integrators of grids: slabs against closed forms, tilings, seams.
#include "render/periodic_scenes.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

const char* const layers[] = {"direct_sun", "multiscatter", "emission", "transmittance", ""};

/// A view of one pixel through `target` along `w`, from above or below.
CameraView through(const Vec3d& target, const Vec3d& w) { return one_pixel(target, w); }

TEST(PeriodicPicture, SlabHasTheRadianceOfTheClosedForm)
{
    constexpr int n = 32;
    const double tau = 1.5, albedo = 0.8, E = 3;
    Scene scene;
    scene.volumes.push_back(volume_of(periodic_layer(n), medium(Vec3d(tau), Vec3d(albedo), 0.4)));
    scene.periodic = xz;
    const Vec3d to_sun = Vec3d(1.2, 1, -0.4).unit();
    scene.lights = {make_sun(to_sun, Vec3d(E))};
    add_light(scene);
    const double mu0 = to_sun[1];
    for (const Vec3d& direction : {Vec3d(0, -1, 0), Vec3d(0.7, -1, 0.2), Vec3d(-2, -0.5, 1), Vec3d(0.3, 1, 0.1),
                                   Vec3d(-1, 0.2, 0.3), Vec3d(5, -0.1, 2)}) {
        const Vec3d w = direction.unit();
        const double mu = std::abs(w[1]), p = scene.volumes[0].medium.phase(to_sun.dot(w));
        const double expected = albedo * E * p * mu0 *
                                (w[1] < 0 ? (1 - std::exp(-tau * (1 / mu + 1 / mu0))) / (mu + mu0)
                                          : (std::exp(-tau / mu0) - std::exp(-tau / mu)) / (mu0 - mu));
        for (const Integrator kind : integrators)
            for (const bool rays : {true, false}) {
                IntegratorOptions o = fine(kind);
                o.shadow_rays = rays;
                double first = 0;
                for (const Vec3d& at : {Vec3d(0.1, 0.4, 0.07), Vec3d(0.2491, 0.4, 0.125), Vec3d(-77.3, 0.4, 1234.5)}) {
                    const Picture picture(scene, through(at, w), o);
                    const double found = picture.at("direct_sun", 0);
                    // In the outermost half voxels depth is a parabola, which grids take as linear: an eighth of 1/32
                    // of the depth to the sun there. Slanting rays see little but that part. Steps of 1/16 voxel err
                    // by less.
                    EXPECT_NEAR(found / expected, 1, (rays ? 2e-4 : 1e-3) / std::min(1.0, 4 * mu)) << name(kind) << w;
                    EXPECT_NEAR(picture.at("transmittance", 1), std::exp(-tau / mu), 1e-5) << name(kind) << w;
                    // The half-open first step of each rule lies elsewhere in a voxel.
                    if (first > 0) {
                        EXPECT_NEAR(found / first, 1, kind == Integrator::Cells ? 1e-6 : 1e-4) << name(kind);
                    }
                    first = found;
                }
            }
    }
}

/// Cells from grids and by shadow rays; the rules of points from grids.
struct Way {
    Integrator kind;
    bool shadow_rays;
};
constexpr Way ways[] = {
    {Integrator::Cells, false}, {Integrator::Cells, true}, {Integrator::Romberg, false}, {Integrator::Steps, false}};

IntegratorOptions options_of(const Way& way)
{
    IntegratorOptions o;
    o.kind = way.kind;
    o.shadow_rays = way.shadow_rays;
    return o;
}

/// The scene with colour, emission and unscaled light; or with collided light of a scaled medium, without colour.
void choose_grids(Scene& scene, bool scaled)
{
    Volume& v = scene.volumes[0];
    if (scaled)
        v.colour = nullptr;
    else
        v.collided = {};
    add_light(scene);
}

TEST(PeriodicPicture, EqualsATilingOfManyCopies)
{
    // Rays and sun are so steep that neither leaves five copies between top and base.
    for (const bool scaled : {false, true}) {
        const Vec3d sigma_t = scaled ? Vec3d(0.2, 0.4, 0.6) : Vec3d(0.5);
        Scene one = periodic_scene({}, sigma_t, 0.7), many = periodic_scene({-2, 2, false}, sigma_t, 0.7);
        for (Scene* scene : {&one, &many}) choose_grids(*scene, scaled);
        for (const Way& way : ways) {
            double light = 0;
            for (const Vec3d& target : {Vec3d(4, 6, 6), Vec3d(15.6, 6, 15.4), Vec3d(-0.3, 5, 0.2)})
                for (const Vec3d& w : {Vec3d(0, -1, 0), Vec3d(0.8, -1, -0.7), Vec3d(-0.5, 1, 0.9)}) {
                    if (way.kind != Integrator::Cells && target[0] != 15.6) continue;
                    const Picture a(one, through(target, w), options_of(way)),
                        b(many, through(target, w), options_of(way));
                    light += b.at("direct_sun", 0);
                    for (const char* layer : layers)
                        for (int c = 0; c < 3; ++c) {
                            // Fixed steps and the trapezia of Romberg begin elsewhere: the tiling's box is larger.
                            // Grids hold floats, as pictures do.
                            const double most = way.kind == Integrator::Cells ? 3e-6 : 0.05;
                            EXPECT_NEAR(a.at(layer, c), b.at(layer, c), most * (1e-3 + b.at(layer, c)))
                                << name(way.kind) << " " << layer << " " << target << w << way.shadow_rays << scaled;
                        }
                }
            EXPECT_GT(light, 0.01);
        }
    }
}

TEST(PeriodicPicture, ShowsNoSeam)
{
    // The medium moved by 3 and -5 voxels, seen by a camera that moves with it.
    const Vec3i shift(3, 0, -5);
    for (const bool scaled : {false, true}) {
        Scene still = periodic_scene({}, Vec3d(0.5), 0.7), moved = periodic_scene({0, 0, true, shift}, Vec3d(0.5), 0.7);
        for (Scene* scene : {&still, &moved}) choose_grids(*scene, scaled);
        for (const Way& way : ways) {
            double light = 0;
            for (const Vec3d& target : {Vec3d(4, 6, 6), Vec3d(15.6, 6, 15.4), Vec3d(-40, 9, 3)})
                for (const Vec3d& w : {Vec3d(0, -1, 0), Vec3d(3, -1, -2), Vec3d(-0.5, 1, 0.9), Vec3d(1, 0.02, 0)}) {
                    if (way.kind != Integrator::Cells && target[0] != 15.6) continue;
                    const Picture a(still, through(target, w), options_of(way)),
                        b(moved, through(target + Vec3d(shift), w), options_of(way));
                    light += b.at("direct_sun", 0);
                    for (const char* layer : layers)
                        EXPECT_NEAR(a.at(layer, 1), b.at(layer, 1), 1e-6 * (1e-3 + b.at(layer, 1)))
                            << name(way.kind) << " " << layer << " " << target << w << way.shadow_rays << scaled;
                }
            EXPECT_GT(light, 0.01);
        }
    }
}

TEST(PeriodicPicture, IsTheSameInEachPeriodAndTurned)
{
    Scene scene = periodic_scene({}, Vec3d(0.5), 0);
    add_light(scene);
    const Picture here(scene, through(Vec3d(8, 6, 8), Vec3d(1, -1, 0.4)), {});
    const Picture there(scene, through(Vec3d(8 + 16 * 123, 6, 8 - 16 * 77), Vec3d(1, -1, 0.4)), {});
    EXPECT_NEAR(here.at("", 0), there.at("", 0), 1e-6);
    // The same in a grid that is turned, mirrored and of other edges.
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m.postScale(openvdb::Vec3d(1, 1, -1));
    m.postRotate(openvdb::math::Y_AXIS, 0.7);
    m.postRotate(openvdb::math::X_AXIS, -0.4);
    const auto transform = openvdb::math::Transform::createLinearTransform(m);
    Scene turned = periodic_scene({}, Vec3d(0.5), 0);
    Volume& v = turned.volumes[0];
    v.density->setTransform(transform);
    v.colour->setTransform(transform);
    v.emission->setTransform(transform);
    v.collided = {};
    Scene plain = scene;
    plain.volumes[0].collided = {};
    turned.lights = {make_sun(m.transform(Vec3d(0.5, 1, -0.3)), Vec3d(2, 3, 5))};
    add_light(turned);
    const Picture a(plain, through(Vec3d(8, 6, 8), Vec3d(1, -1, 0.4)), {}),
        b(turned, through(m.transform(Vec3d(8, 6, 8)), m.transform(Vec3d(1, -1, 0.4))), {});
    for (const char* layer : layers)
        EXPECT_NEAR(a.at(layer, 0), b.at(layer, 0), 2e-6 * (1e-3 + a.at(layer, 0))) << layer;
}

TEST(PeriodicPicture, TwoVolumesAreOneOfAddedDensity)
{
    Scene one = periodic_scene({}, Vec3d(0.5), 0), two = one;
    for (Scene* scene : {&one, &two}) {
        scene->volumes[0].collided = {};
        scene->volumes[0].colour = nullptr;
        scene->volumes[0].emission = nullptr;
    }
    two.volumes.push_back(two.volumes[0]);
    for (size_t v = 0; v < 2; ++v) {
        auto half = one.volumes[0].density->deepCopy();
        for (auto value = half->beginValueOn(); value; ++value) value.setValue(0.5f * *value);
        // The second one begins elsewhere in its period.
        if (v == 1) {
            auto moved = FloatGrid::create(0.0f);
            for (auto value = half->cbeginValueOn(); value; ++value)
                moved->tree().setValueOn(
                    value.getCoord()[0] < 5 ? value.getCoord().offsetBy(16, 0, 0) : value.getCoord(), *value);
            half = moved;
        }
        two.volumes[v].density = half;
    }
    IntegratorOptions o;
    o.shadow_rays = true;
    for (const Vec3d& w : {Vec3d(0, -1, 0), Vec3d(3, -1, -2), Vec3d(-0.5, 1, 0.9), Vec3d(1, 0, 0.3)}) {
        const Picture a(one, through(Vec3d(3, 6, 8), w), o), b(two, through(Vec3d(3, 6, 8), w), o);
        for (const char* layer : {"direct_sun", "transmittance"})
            EXPECT_NEAR(a.at(layer, 0), b.at(layer, 0), 1e-6 * (1e-3 + a.at(layer, 0))) << layer << w;
    }
    // From light grids: each through both.
    std::vector<CrossedMedium> media;
    for (const Volume& v : two.volumes) media.push_back({v.density, v.medium});
    TransmittanceOptions light;
    light.periodic = xz;
    for (size_t v = 0; v < 2; ++v) two.volumes[v].transmittance = {transmittance_grid(media, v, two.lights[0], light)};
    add_light(one);
    const Picture a(one, through(Vec3d(3, 6, 8), Vec3d(3, -1, -2)), {}),
        b(two, through(Vec3d(3, 6, 8), Vec3d(3, -1, -2)), {});
    EXPECT_NEAR(a.at("direct_sun", 0) / b.at("direct_sun", 0), 1, 1e-5);
}

TEST(PeriodicPicture, RaysWithinTheLayerEnd)
{
    // Row 2 is empty but for its neighbours' slopes; in the middle of rows 6 to 9 there is nothing at all.
    const auto grid = box({16, 14, 16}, 1, [](Coord c) { return c[1] < 2 || (c[1] > 2 && c[1] < 6) || c[1] > 9; });
    Scene scene;
    scene.volumes.push_back(volume_of(grid, medium(Vec3d(0.5, 0.2, 1), Vec3d(0.9), 0.3)));
    scene.lights = {make_sun(Vec3d(0.5, 1, 0.2))};
    scene.periodic = xz;
    add_light(scene);
    for (const Integrator kind : {Integrator::Cells, Integrator::Romberg})
        for (const Vec3d& w : {Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(-1, 0, 0.37)}) {
            IntegratorOptions o;
            o.kind = kind;
            const Picture dense(scene, through(Vec3d(8, 4, 8), w), o);
            EXPECT_NEAR(dense.at("", 3), 1, 1e-6);
            EXPECT_GT(dense.at("direct_sun", 0), 1e-3);
            EXPECT_LT(dense.cost.cells, 10000u);
            const Picture empty(scene, through(Vec3d(8, 8, 8), w), o);
            EXPECT_EQ(empty.at("", 3), 0) << name(kind) << w;
        }
}

TEST(PeriodicPicture, DoesNotDependOnThreads)
{
    Scene scene = periodic_scene({}, Vec3d(0.5), 0);
    Camera camera;
    camera.position = Vec3d(3, 40, 5);
    camera.look_at = Vec3d(20, 6, 30);
    ImageSize size;
    size.width = size.height = 24;
    const CameraView view(camera, size);
    std::vector<std::vector<float>> pictures;
    for (const int threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
        scene.volumes[0].transmittance.clear();
        add_light(scene);
        for (const Integrator kind : {Integrator::Cells, Integrator::Path}) {
            Film film(size, render_layers(scene, {"all"}, kind));
            IntegratorOptions o;
            o.kind = kind;
            o.passes = {};
            SamplingOptions sampling;
            sampling.samples = kind == Integrator::Path ? 4 : 1;
            render_image(film, scene, view, sampling, o);
            std::vector<float> values;
            for (int j = 0; j < 24; ++j)
                for (int i = 0; i < 24; ++i)
                    values.insert(values.end(), film.pixel(i, j), film.pixel(i, j) + film.channels());
            pictures.push_back(values);
        }
    }
    EXPECT_EQ(pictures[0], pictures[2]);
    EXPECT_EQ(pictures[1], pictures[3]);
    EXPECT_NE(pictures[0], pictures[1]);
}

TEST(PeriodicPicture, RefusesWhatCannotRepeat)
{
    const auto refused = [](Scene scene, const std::string& why) {
        for (const Integrator kind : {Integrator::Cells, Integrator::Path}) {
            IntegratorOptions o;
            o.kind = kind;
            o.shadow_rays = kind == Integrator::Cells;
            try {
                Picture(scene, one_pixel(Vec3d(0), Vec3d(0, 1, 0)), o);
                ADD_FAILURE() << "taken: " << why;
            } catch (const InputError& e) {
                EXPECT_NE(std::string(e.what()).find(why), std::string::npos) << e.what();
            }
        }
    };
    const Scene scene = periodic_scene({}, Vec3d(0.5), 0);
    Scene other = scene;
    other.lights = {make_lamp(Vec3d(3, 50, 3))};
    refused(other, "expected a light at infinity");
    other.lights = {make_sun(Vec3d(0.3, 0, 1))};
    refused(other, "not parallel to every axis that ends");
    other = scene;
    other.periodic = {true, true, true};
    refused(other, "expected an axis along which it ends");
    other = scene;
    other.volumes.push_back(volume_of(box({8, 12, 16}, 1, [](Coord) { return 1.0; }), scene.volumes[0].medium));
    refused(other, "expected equal periods");
    other = scene;
    other.volumes[0].emission = scene.volumes[0].emission->deepCopy();
    other.volumes[0].emission->tree().setValueOn(Coord(16, 3, 3), Vec3f(1.0f));
    refused(other, "emission beyond the period");
    other = scene;
    other.volumes[0].colour = scene.volumes[0].colour->deepCopy();
    other.volumes[0].colour->setTransform(openvdb::math::Transform::createLinearTransform(0.7));
    refused(other, "whole voxels in its period");
    other = scene;
    other.volumes.push_back(volume_of(FloatGrid::create(0.0f), scene.volumes[0].medium));
    other.volumes[1].emission = scene.volumes[0].emission;
    refused(other, "the density gives the period");

    TransmittanceOptions o;
    o.periodic = xz;
    EXPECT_THROW(transmittance_grid(*scene.volumes[0].density, scene.volumes[0].medium, make_lamp(Vec3d(1)), o),
                 InputError);
}

}  // namespace
}  // namespace vdbcloud
