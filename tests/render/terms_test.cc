// Every layer of a picture against a closed form, with each of the three integrators and on grids of any transform.
#include "pictures.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/phase_function.h"

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;
using test::constant_like;
using test::cube;
using test::fine;
using test::integrators;
using test::medium;
using test::one_pixel;
using test::Picture;
using test::volume_of;

// ---- light scattered more than once ----

/// phi, flux and a share f of forward scattering: S = w0 (1 - f) / (1 - f w0) (phi + 3 g' s.F) / (4 pi) everywhere, so
/// that L = S (1 - T'), T' = T^(1 - f w0), whatever the density along the ray.
struct Gathered {
    Vec3d sigma_t{0.05, 0.1, 0.2}, albedo{0.9, 0.8, 0.6};
    double forward = 0.36, mean_cosine = 0.375;
    Vec3d phi{1, 2, 3};
    Vec3d flux[3] = {{0.2, -0.1, 0.3}, {-0.4, 0.2, 0.1}, {0.1, 0.5, -0.3}};

    Volume volume(const FloatGridPtr& density) const
    {
        Volume v = volume_of(density, medium(sigma_t, albedo, 0.6));
        v.collided.scaling.delta_f = forward;
        v.collided.scaling.moments = {1, mean_cosine};
        v.collided.phi = constant_like<Vec3SGrid>(*density, Vec3f(phi));
        for (size_t c = 0; c < 3; ++c) v.collided.flux[c] = constant_like<Vec3SGrid>(*density, Vec3f(flux[c]));
        return v;
    }
    /// sigma_t of the scaled medium at density 1.
    Vec3d extinction() const { return sigma_t * (Vec3d(1) - forward * albedo); }
    /// Of channel c, for the true transmittance T; s towards the eye.
    double radiance(int c, double T, const Vec3d& s) const
    {
        const double w = albedo[c], source = (phi[c] + 3 * mean_cosine * s.dot(flux[c])) / (4 * M_PI);
        return w * (1 - forward) / (1 - forward * w) * source * (1 - std::pow(T, 1 - forward * w));
    }
};

TEST(Layers, MultiscatterIsTheScaledSourceTimesTheScaledOpacity)
{
    const Gathered gathered;
    Scene scene;
    scene.volumes.push_back(gathered.volume(cube()));
    for (const Integrator kind : integrators)
        for (const Vec3d& s : {Vec3d(0, 0, 1), Vec3d(-1, 0, 0), Vec3d(0.36, 0.48, 0.8)}) {
            const Picture picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), -s), fine(kind));
            for (int c = 0; c < 3; ++c) {
                const double T = picture.at("transmittance", c);
                if (s[0] * s[1] * s[2] == 0) {  // along an axis: T = exp(-16 sigma_t), without scaling
                    EXPECT_NEAR(T, std::exp(-16 * gathered.sigma_t[c]), 1e-4) << name(kind);
                }
                EXPECT_NEAR(picture.at("multiscatter", c) / gathered.radiance(c, T, s), 1, 5e-4)
                    << name(kind) << ' ' << s << ' ' << c;
                EXPECT_NEAR(picture.at("", c), picture.at("multiscatter", c), 1e-6);
            }
            double opacity = 1;  // alpha is of the scaled medium
            for (int c = 0; c < 3; ++c)
                opacity -= std::pow(picture.at("transmittance", c), 1 - gathered.forward * gathered.albedo[c]) / 3;
            EXPECT_NEAR(picture.at("", 3), opacity, 1e-4) << name(kind);
        }
}

TEST(Layers, MultiscatterDoesNotDependOnTheGridsTransform)
{
    // Flux is in world components: on grids turned, mirrored, sheared and of voxels that are not cubes the closed form
    // is the same function of what the ray's own transmittance is.
    const Gathered gathered;
    auto odd = openvdb::math::Transform::createLinearTransform(1.0);
    odd->postRotate(0.31, openvdb::math::X_AXIS);
    odd->postRotate(-1.7, openvdb::math::Z_AXIS);
    auto mirrored = odd->copy();
    mirrored->preScale(Vec3d(1, -1, 1));
    auto uneven = odd->copy();
    uneven->preScale(Vec3d(0.5, 1, 1.7));
    auto sheared = odd->copy();
    sheared->preShear(0.4, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
    for (const auto& transform : {odd, mirrored, uneven, sheared}) {
        const auto density = cube();
        density->setTransform(transform);
        Scene scene;
        scene.volumes.push_back(gathered.volume(density));
        const Vec3d s(0.48, -0.6, 0.64), middle = transform->indexToWorld(Vec3d(7.6, 7.3, 7.9));
        for (const Integrator kind : integrators) {
            const Picture picture(scene, one_pixel(middle, -s), fine(kind));
            for (int c = 0; c < 3; ++c) {
                const double T = picture.at("transmittance", c);
                EXPECT_GT(1 - T, 0.2);
                EXPECT_NEAR(picture.at("multiscatter", c) / gathered.radiance(c, T, s), 1, 5e-4) << name(kind) << c;
            }
        }
    }
}

TEST(Layers, MultiscatterAndEmissionOfOverlappingVolumesAreOneSource)
{
    // Two bodies on lattices of their own, each with the source functions of the other: along any ray the sum is that
    // source times the opacity of both.
    Gathered gathered;
    const Vec3d glow(2, 1, 0.5);
    Scene scene, one;
    for (const Vec3d& shift : {Vec3d(0), Vec3d(5.3, -0.7, 2.2)}) {
        const auto density = box({16, 16, 16}, 1, [](Coord c) { return 0.3 + 0.1 * (c[0] % 5) + 0.05 * (c[2] % 7); });
        const auto transform = density->transform().copy();
        transform->postTranslate(shift);
        density->setTransform(transform);
        Volume volume = gathered.volume(density);
        volume.emission = Vec3SGrid::create(Vec3f(0));
        volume.emission->setTransform(transform->copy());
        for (auto v = density->cbeginValueOn(); v; ++v)
            volume.emission->tree().setValueOn(v.getCoord(), Vec3f(*v * gathered.extinction() * glow));
        scene.volumes.push_back(volume);
    }
    one.volumes.push_back(scene.volumes[0]);
    const Vec3d s(0.48, -0.6, 0.64);
    const auto view = one_pixel(Vec3d(8.6, 7.3, 8.9), -s);
    for (const Integrator kind : integrators) {
        const Picture both(scene, view, fine(kind)), first(one, view, fine(kind));
        for (int c = 0; c < 3; ++c) {
            const double T = both.at("transmittance", c);
            EXPECT_LT(T, 0.9 * first.at("transmittance", c));
            EXPECT_NEAR(both.at("multiscatter", c) / gathered.radiance(c, T, s), 1, 1e-3) << name(kind) << c;
            // Densities change by up to a half from voxel to voxel: (sigma h)^4 / 10 of the source and kinks.
            const double opacity = 1 - std::pow(T, 1 - gathered.forward * gathered.albedo[c]);
            EXPECT_NEAR(both.at("emission", c) / (glow[c] * opacity), 1, 1e-3) << name(kind) << c;
        }
    }
}

// ---- light scattered once ----

TEST(Layers, DirectLightOfAScaledMediumIsAttenuatedBothWays)
{
    // Sun behind the camera along an axis, light's depth of the scaled medium: L = w0 p(-1) E / (1 - f w0) (1 - T'^2)
    // / 2.
    const auto density = cube();
    const double f = 0.36, w0 = 0.8, sigma_t = 0.1, g = 0.6;
    Medium scaled = medium(Vec3d((1 - f * w0) * sigma_t), Vec3d(w0), g);
    Scene scene;
    const Light key = make_sun(Vec3d(0, 0, 1), Vec3d(2, 3, 5), 0, "key"),
                fill = make_sun(Vec3d(0, 0, 1), Vec3d(7, 0, 1), 0, "fill");
    scene.lights = {key, fill};
    Volume volume = volume_of(density, medium(Vec3d(sigma_t), Vec3d(w0), g));
    volume.collided.scaling.delta_f = f;
    for (const Light& light : scene.lights)
        volume.transmittance.push_back(
            transmittance_grid(*density, scaled, light, TransmittanceOptions{Fidelity::Exact}));
    scene.volumes.push_back(volume);
    const double T = std::exp(-16 * (1 - f * w0) * sigma_t);
    const double p = (1 - g * g) / std::pow(1 + g, 3) / (4 * M_PI);  // Henyey-Greenstein, light turned back
    for (const Integrator kind : integrators)
        for (const bool plain : {true, false}) {
            IntegratorOptions options = fine(kind);
            options.plain_path = plain;
            const Picture picture(scene, one_pixel(Vec3d(7.5, 7.5, 7.5), Vec3d(0, 0, -1)), options);
            for (int c = 0; c < 3; ++c) {
                // The light's depth is interpolated linearly where density ramps: (sigma_t h)^2 / 8 there.
                EXPECT_NEAR(picture.at("direct_key", c), w0 * p * key.strength()[c] / (1 - f * w0) * (1 - T * T) / 2,
                            5e-4 * key.strength()[c] * p)
                    << name(kind);
                EXPECT_NEAR(picture.at("direct_fill", c) * key.strength()[c],
                            picture.at("direct_key", c) * fill.strength()[c], 1e-5);
                EXPECT_NEAR(picture.at("", c), picture.at("direct_key", c) + picture.at("direct_fill", c), 1e-6);
            }
        }
}

TEST(Layers, DirectLightIsTintedByColour)
{
    const auto density = cube();
    Scene scene;
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    scene.lights = {sun};
    Volume volume = volume_of(density, medium(Vec3d(0.1), Vec3d(0.8), 0.3));
    volume.transmittance.push_back(transmittance_grid(*density, volume.medium, sun, {}));
    volume.colour = constant_like<Vec3SGrid>(*density, Vec3f(0.5f, 0.25f, 2.0f));
    // Colour is 1 outside its active voxels: let it reach as far as the medium does.
    volume.colour->fill(openvdb::CoordBBox(Coord(-2), Coord(17)), Vec3f(0.5f, 0.25f, 2.0f));
    Scene plain = scene;
    plain.volumes.push_back(volume);
    plain.volumes[0].colour = nullptr;
    scene.volumes.push_back(volume);
    const auto view = one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(1, -0.3, 0.5));
    for (const Integrator kind : integrators) {
        const Picture tinted(scene, view, fine(kind)), grey(plain, view, fine(kind));
        EXPECT_GT(grey.at("direct_sun", 0), 0.01);
        const double factor[3] = {0.5, 0.25, 1 / 0.8};  // the albedo is at most 1
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(tinted.at("direct_sun", c) / grey.at("direct_sun", c), factor[c], 1e-5) << name(kind) << c;
    }
}

TEST(Layers, DirectLightOfAPointLightFallsWithTheSquareOfItsDistance)
{
    // A medium so thin that nothing is attenuated: L = w0 sigma I int p(cos) / r^2 dt over the ray, the density ramping
    // from 0 to 1 over the voxel about each face. Summed here point by point.
    const auto density = cube();
    const double sigma_t = 1e-6, w0 = 0.8, g = 0.5;
    for (const Integrator kind : integrators)
        for (double distance : {4.0, 12.0, 36.0}) {
            Scene scene;
            const Light lamp = make_lamp(Vec3d(7.5 + distance, 7.5, 3), Vec3d(1e6, 2e6, 0));
            scene.lights = {lamp};
            scene.volumes.push_back(volume_of(density, medium(Vec3d(sigma_t), Vec3d(w0), g)));
            scene.volumes[0].transmittance.push_back(openvdb::FloatGrid::create(1.0f));
            const Picture picture(scene, one_pixel(Vec3d(7.5, 7.5, 7.5), Vec3d(0, 0, -1)), fine(kind));
            double sum = 0;
            const int points = 20000;
            for (int n = 0; n < points; ++n) {
                const double z = -1 + 18 * (n + 0.5) / points, ramp = std::min({1.0, z + 1, 16 - z});
                if (ramp <= 0) continue;
                const Vec3d to = lamp.place() - Vec3d(7.5, 7.5, z);  // the ray travels along -z
                const double r = to.length(), cosine = (-to / r).dot(Vec3d(0, 0, 1));
                sum += ramp / (r * r) * scene.volumes[0].medium.phase(cosine) * 18 / points;
            }
            // Cells take p at the middle of a cell and the mean of 1/r^2 over it: second order, (h / r)^2 / 24 of it.
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(picture.at("direct_lamp", c), w0 * sigma_t * lamp.strength()[c] * sum,
                            4e-3 * w0 * sigma_t * lamp.strength()[c] * sum)
                    << name(kind) << ' ' << distance;
            EXPECT_NEAR(picture.at("direct_lamp", 1), 2 * picture.at("direct_lamp", 0), 1e-6);
        }
}

// ---- emission, depth, sums ----

TEST(Layers, EmissionIsItsSourceTimesTheOpacity)
{
    const auto density = cube();
    const Vec3d sigma_t(0.05, 0.1, 0.3), source(2, 1, 0.5);
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(sigma_t, Vec3d(0), 0)));
    scene.volumes[0].emission = constant_like<Vec3SGrid>(*density, Vec3f(sigma_t * source));
    for (const Integrator kind : integrators)
        for (const Vec3d& direction : {Vec3d(0, 1, 0), Vec3d(0.36, 0.48, -0.8)}) {
            const Picture picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), direction), fine(kind));
            for (int c = 0; c < 3; ++c) {
                // Cells: (sigma h)^4 / 10 of the source.
                EXPECT_NEAR(picture.at("emission", c), source[c] * (1 - picture.at("transmittance", c)),
                            1e-3 * source[c])
                    << name(kind) << c;
                EXPECT_EQ(picture.at("", c), picture.at("emission", c));
                EXPECT_EQ(picture.at("multiscatter", c), 0);
            }
        }
}

TEST(Layers, BeautyIsTheSumOfItsParts)
{
    const Gathered gathered;
    const auto density = cube();
    Scene scene;
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    scene.lights = {sun};
    Volume volume = gathered.volume(density);
    volume.emission = constant_like<Vec3SGrid>(*density, Vec3f(0.01f, 0.02f, 0.04f));
    volume.transmittance.push_back(transmittance_grid(*density, volume.medium, sun, {}));
    scene.volumes.push_back(volume);
    for (const Integrator kind : integrators) {
        const Picture picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(1, -0.3, 0.5)), fine(kind));
        for (int c = 0; c < 3; ++c) {
            for (const char* layer : {"direct_sun", "multiscatter", "emission"})
                EXPECT_GT(picture.at(layer, c), 0.005) << layer;
            EXPECT_NEAR(picture.at("", c),
                        picture.at("direct_sun", c) + picture.at("multiscatter", c) + picture.at("emission", c), 1e-6);
        }
    }
}

TEST(Layers, DepthIsWhereTheMeanTransmittanceOfTheChannelsIsOneHalf)
{
    // Uniform, three extinctions, scaled by 1 - f w0: (exp(-a x) + exp(-b x) + exp(-c x)) / 3 = 1/2, solved here.
    const auto density = cube();
    const double f = 0.36, w0 = 0.5;
    const Vec3d sigma_t = Vec3d(0.02, 0.1, 0.5) / (1 - f * w0);
    double low = 0, high = 16;
    for (int n = 0; n < 60; ++n) {
        const double x = (low + high) / 2;
        (std::exp(-0.02 * x) + std::exp(-0.1 * x) + std::exp(-0.5 * x) > 1.5 ? low : high) = x;
    }
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(sigma_t, Vec3d(w0), 0.6)));
    scene.volumes[0].collided.scaling.delta_f = f;
    for (const Integrator kind : integrators) {
        const Picture picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(0, 0, -1)), fine(kind));
        // From the camera's plane 100 above 7.9 to half a voxel above the last centre, then x. Between two points
        // -log T is taken as linear: its second derivative, 0.04, times h^2 / 8 over its slope of 0.15; h is a cell, at
        // most 17/64 with Romberg or a step of 1/16.
        const double most = kind == Integrator::Cells ? 0.04 : kind == Integrator::Romberg ? 5e-3 : 1e-3;
        EXPECT_NEAR(picture.at("Z", 0), 107.9 - 15.5 + low, most) << name(kind);
    }
    scene.volumes[0].medium.sigma_t_per_density = Vec3d(1e-3);
    for (const Integrator kind : integrators)
        EXPECT_EQ(Picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(0, 0, -1)), fine(kind)).at("Z", 0), 1e30f);
}

TEST(Layers, DepthIsAlongTheViewAxis)
{
    const auto density = box({60, 60, 8}, 1, [](Coord) { return 1.0; });
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(Vec3d(40), Vec3d(1), 0)));
    Camera camera;
    camera.position = Vec3d(30, 30, 50);
    camera.look_at = Vec3d(30, 30, 0);
    camera.fov = 60;
    ImageSize size;
    size.width = size.height = 9;
    const CameraView view(camera, size);
    Film film(size, render_layers(scene, {"Z"}));
    render_image(film, scene, view, {}, {});
    // An opaque sheet whose surface is at z = 8: half the light is lost within the ramp of its first voxel.
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(film.pixel(i, 4)[film.offset(film.find("Z"))], 50 - 7.9, 0.1) << i;
}

// ---- options and cost of the integrators ----

TEST(Integrators, StepsAreAFractionOfTheShortestVoxelEdge)
{
    const auto density = cube();
    auto uneven = openvdb::math::Transform::createLinearTransform(openvdb::math::Mat4d::identity());
    uneven->preScale(Vec3d(2, 0.5, 1));
    density->setTransform(uneven);
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(Vec3d(0.1), Vec3d(1), 0)));
    IntegratorOptions o;
    o.kind = Integrator::Steps;
    o.step = 0.25;
    // Along x the medium reaches from voxel -1 to 16: 17 voxels of length 2, in steps of 0.25 x 0.5.
    EXPECT_EQ(Picture(scene, one_pixel(Vec3d(15, 3.7, 7.5), Vec3d(1, 0, 0)), o).cost.cells, 17u * 2 * 8);
    EXPECT_EQ(Picture(scene, one_pixel(Vec3d(15, 3.7, 7.5), Vec3d(0, 0, 1)), o).cost.cells, 17u * 8);
}

TEST(Integrators, RombergGainsTwoOrdersInEachColumn)
{
    // Voxels 1 to 14 of a box from -1 to 15: density's kinks at 0, 1, 14 and 15 are points of every level from 2^4
    // intervals on, so that errors of the trapezoid sums are series in h^2 and each column of the table gains two
    // orders.
    const auto density = box({15, 15, 15}, 1, [](Coord c) { return c[0] && c[1] && c[2] ? 1.0 : 0.0; });
    for (auto v = density->beginValueOn(); v; ++v)
        if (*v == 0) v.setValueOff();
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(Vec3d(0.2), Vec3d(0), 0)));
    scene.volumes[0].emission = constant_like<Vec3SGrid>(*density, Vec3f(0.2f));
    density->tree().setValueOn(Coord(0), 0);  // the corner of the box
    // Evaluations by a table of the same sums that was worked out apart; a table of half the orders needs four times as
    // many.
    for (const auto& [tolerance, evaluations] : {std::pair(1e-4, 65u), {1e-6, 129u}, {1e-8, 257u}}) {
        IntegratorOptions o = fine(Integrator::Romberg);
        o.tolerance = tolerance;
        const Picture picture(scene, one_pixel(Vec3d(7.5, 7.5, 7.5), Vec3d(0, 0, -1)), o);
        EXPECT_EQ(picture.cost.cells, evaluations) << tolerance;
        EXPECT_NEAR(picture.at("emission", 0), 1 - std::exp(-0.2 * 14), 1e-6) << tolerance;
    }
}

TEST(Integrators, CellsVisitEachCellOnceAndRombergReportsRaysThatDoNotConverge)
{
    const auto density = box({16, 16, 16}, 1, [](Coord c) { return c[2] % 4 ? 0.0 : 50.0; });
    Scene scene;
    scene.volumes.push_back(volume_of(density, medium(Vec3d(0.3), Vec3d(0.5), 0)));
    scene.volumes[0].emission = constant_like<Vec3SGrid>(*density, Vec3f(1.0f));
    const auto view = one_pixel(Vec3d(7.5, 7.5, 7.5), Vec3d(0, 0, -1));
    IntegratorOptions o;
    o.kind = Integrator::Romberg;
    o.tolerance = 1e-12;
    const Picture hard(scene, view, o);
    EXPECT_EQ(hard.cost.unconverged, 1u);
    EXPECT_EQ(hard.cost.cells, 4097u);  // 2^12 intervals
    o.tolerance = 1e4;
    const Picture loose(scene, view, o);
    EXPECT_EQ(loose.cost.unconverged, 0u);
    EXPECT_EQ(loose.cost.cells, 33u);  // 2^5 intervals at least
    EXPECT_EQ(loose.cost.rays, 1u);
    Scene plain;
    plain.volumes.push_back(volume_of(cube(), medium(Vec3d(0.3), Vec3d(0.5), 0)));
    EXPECT_EQ(Picture(plain, view, {}).cost.cells, 17u);
}

}  // namespace
}  // namespace vdbcloud
