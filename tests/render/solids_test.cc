// Solids in pictures, by all integrators: closed forms, identities, and light paths as the measure of the others.
#include "render/path_estimates.h"
#include "support/grids.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

Vec3d everything(const RayResult& r) { return all_light(r) + r.ground + r.solid; }

Material diffuse(const Vec3d& colour)
{
    Material m;
    m.colour = colour;
    return m;
}

Material mirror(const Vec3d& colour)
{
    Material m = diffuse(colour);
    m.finish = Finish::Mirror;
    return m;
}

FloatGridPtr level_set_ball(double radius, const Vec3d& middle, double edge)
{
    auto grid = openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius), Vec3f(middle), float(edge));
    grid->setName("solid");
    return grid;
}

/// Transmittance grids of all lights for the scene's only volume.
void light(Scene& scene)
{
    Volume& v = scene.volumes.at(0);
    v.transmittance.clear();
    TransmittanceOptions o;
    o.fidelity = Fidelity::Exact;
    o.solids = scene.solids;
    for (const Light& l : scene.lights) v.transmittance.push_back(transmittance_grid(*v.density, v.medium, l, o));
}

Scene clear_scene()
{
    Scene scene;
    scene.volumes.push_back(volume_of(FloatGrid::create(0.0f), medium(Vec3d(1.0), Vec3d(1.0), 0)));
    return scene;
}

TEST(SolidRays, ReflectNothingThroughTheirSurface)
{
    const Vec3d normal = Vec3d(1, 2, -2) / 3, along = Vec3d(2, 1, 2) / 3;
    for (const Finish finish : {Finish::Diffuse, Finish::Glossy}) {
        Material m = diffuse(Vec3d(1.0));
        m.finish = finish, m.roughness = 0.5;
        // A viewer near the surface, so that half of a glossy lobe lies below.
        const Reflection reflection(m, normal, (along + 0.1 * normal).unit());
        double sum = 0;
        const int n = 20000;
        for (int k = 0; k < n; ++k) {
            const double c = -1 + 2 * (k + 0.5) / n;
            const double value = reflection.value(direction_about(normal, c, 2.399963229728653 * k));
            sum += 4 * pi / n * value;
            if (c >= 0) continue;
            ASSERT_EQ(value, 0) << c;
        }
        EXPECT_LT(sum, 1.001);
        EXPECT_GT(sum, finish == Finish::Diffuse ? 0.999 : 0.1);
    }
}

TEST(SolidRays, MeetEachShapeInClosedForm)
{
    const double edge = 1.0 / 16;
    const SolidRays solids({make_ball(Vec3d(0), 1), make_box(Vec3d(3, -1, -1), Vec3d(5, 1, 1)),
                            make_plane(Vec3d(0, -2, 0), Vec3d(0, 1, 0)),
                            make_level_set(level_set_ball(1, Vec3d(10, 0, 0), edge))});
    const auto hit = [&](const Vec3d& from, const Vec3d& way) { return solids.nearest({from, way.unit()}); };
    ASSERT_TRUE(hit(Vec3d(-4, 0.6, 0), Vec3d(1, 0, 0)));
    EXPECT_NEAR(hit(Vec3d(-4, 0.6, 0), Vec3d(1, 0, 0))->t, 4 - 0.8, 1e-12);
    EXPECT_LT((hit(Vec3d(-4, 0.6, 0), Vec3d(1, 0, 0))->normal - Vec3d(-0.8, 0.6, 0)).length(), 1e-12);
    EXPECT_NEAR(hit(Vec3d(2, 0.6, 0), Vec3d(1, 0, 0))->t, 1, 1e-12);
    EXPECT_EQ(hit(Vec3d(2, 0.6, 0), Vec3d(1, 0, 0))->normal, Vec3d(-1, 0, 0));
    EXPECT_NEAR(hit(Vec3d(2, 8, 6), Vec3d(0, -1, 0))->t, 10, 1e-12);
    EXPECT_FALSE(hit(Vec3d(2, 8, 6), Vec3d(0, 1, 0)));
    EXPECT_FALSE(solids.nearest({Vec3d(-4, 0, 0), Vec3d(1, 0, 0)}, 2.9));
    // OpenVDB's distances are exact at voxels. Between them the trilinear interpolant of a ball of 16 voxels lies up to
    // h^2 / (8 R) x 2 = 1/64 voxel too high (the ball too small).
    for (const double b : {0.0, 0.3, 0.71}) {
        const auto met = hit(Vec3d(6, b, 0), Vec3d(1, 0, 0));
        ASSERT_TRUE(met);
        EXPECT_EQ(met->solid, 3u);
        const double cosine = std::sqrt(1 - b * b), late = met->t - (4 - cosine);
        EXPECT_GT(late, -1e-6);
        EXPECT_LT(late, edge / 64 / cosine + 1e-6) << b;
        EXPECT_LT((met->normal - Vec3d(-cosine, b, 0)).length(), 0.01) << b;
        EXPECT_FALSE(solids.inside(met->outside));
    }
    EXPECT_TRUE(solids.inside(Vec3d(10, 0, 0))) << "beyond the band, too";
    EXPECT_TRUE(solids.inside(Vec3d(4, 0, 0)));
    EXPECT_FALSE(solids.inside(Vec3d(2, 0, 0)));
    EXPECT_EQ(hit(Vec3d(10, 0, 0), Vec3d(1, 0, 0))->t, 0) << "from within";
    EXPECT_FALSE(solids.blocked({Vec3d(8.9, 0, 0), Vec3d(0, 1, 0)}, 1e9));
    EXPECT_TRUE(solids.blocked({Vec3d(8.9, 0, 0), Vec3d(1, 0, 0)}, 0.2));
    EXPECT_FALSE(solids.blocked({Vec3d(8.9, 0, 0), Vec3d(1, 0, 0)}, 0.05));
}

TEST(Solids, AreLitInClosedFormByASunAndASky)
{
    // Without media: albedo (E cos / pi + L) on a plane under a uniform sky of L; half of the sky on an upright wall
    // that stands on a black plane.
    for (const double albedo : {0.3, 1.0}) {
        Scene scene = clear_scene();
        scene.lights = {make_sun(Vec3d(0, 0.6, 0.8), Vec3d(1, 2, 3))};
        scene.background = scene.sky = Sky::constant(Vec3d(0.5));
        scene.solids = {make_plane(Vec3d(0, -1, 0), Vec3d(0, 1, 0), diffuse(Vec3d(albedo)))};
        light(scene);
        const CameraView down = one_pixel(Vec3d(0, -1, 0), Vec3d(0.3, -1, 0.2));
        for (const Integrator kind : integrators) {
            const Picture picture(scene, down, fine(kind));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(picture.at("solid", c), albedo * (0.6 * (c + 1) / pi + 0.5), 1e-6) << name(kind);
            EXPECT_EQ(picture.at("background", 0), 0);
            EXPECT_EQ(picture.at("", 3), 1);
            EXPECT_NEAR(picture.at("Z", 0), 100, 1e-4);
        }
        const Estimate path = traced(
            scene, 200, [&](int) { return down.ray(0.5, 0.5); }, [](const RayResult& r) { return r.solid; });
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(path.mean[c], albedo * (0.6 * (c + 1) / pi + 0.5), 1e-12);

        scene.solids = {make_plane(Vec3d(0, -1, 0), Vec3d(0, 1, 0), diffuse(Vec3d(0.0))),
                        make_box(Vec3d(-500, -2, -2), Vec3d(500, 1000, -1), diffuse(Vec3d(albedo)))};
        scene.lights.clear();
        light(scene);
        IntegratorOptions many;
        many.solid_rays = 4096;
        // The even pattern of 4096 directions counts half of the directions to 1e-3.
        EXPECT_NEAR(Picture(scene, one_pixel(Vec3d(0, 0, -1), Vec3d(0, 0, -1)), many).at("solid", 0), albedo * 0.25,
                    1e-3 * albedo + 2e-3 * 0.25);
    }
}

TEST(Solids, AGlossyPlaneSeenFromAboveLosesNothing)
{
    // Seen along its normal no part of the lobe lies below the surface: all of a uniform sky comes back, times the
    // colour.
    for (const double roughness : {0.1, 0.4, 0.9}) {
        Scene scene = clear_scene();
        scene.background = scene.sky = Sky::constant(Vec3d(0.5));
        Material glossy = diffuse(Vec3d(0.8));
        glossy.finish = Finish::Glossy;
        glossy.roughness = roughness;
        scene.solids = {make_plane(Vec3d(0, -1, 0), Vec3d(0, 1, 0), glossy)};
        const CameraView down = one_pixel(Vec3d(0, -1, 0), Vec3d(0, -1, 0));
        IntegratorOptions many;
        many.solid_rays = 4096;
        // Of 4096 directions in an even pattern: 1e-3.
        EXPECT_NEAR(Picture(scene, down, many).at("solid", 0), 0.4, 4e-4) << roughness;
        const Estimate path = traced(
            scene, 20000, [&](int) { return down.ray(0.5, 0.5); }, [](const RayResult& r) { return r.solid; });
        EXPECT_NEAR(path.mean[0], 0.4, sigmas * path.error[0] + 1e-12) << roughness;
        EXPECT_LT(path.error[0], 0.004);
    }
}

TEST(Solids, MirrorShowsWhatTheMirroredCameraSees)
{
    // A cube of cloud over a mirror, seen in the mirror, and from below it without the mirror.
    Scene scene;
    const Medium m = medium(Vec3d(0.1), Vec3d(0.9), 0.4);
    scene.volumes.push_back(volume_of(cube(), m));
    scene.lights = {make_sun(Vec3d(0.2, 1, 0.3), Vec3d(3, 2, 1))};
    scene.background = scene.sky = Sky::constant(Vec3d(0.2, 0.3, 0.4));
    light(scene);
    const Vec3d middle(7.5, 7.5, 7.5), mirrored(7.5, -4 - 11.5, 7.5), way(0.3, -1, 0.1);
    const Vec3d up_way(way[0], -way[1], way[2]);
    for (const Integrator kind : integrators) {
        const Picture seen(scene, one_pixel(middle, up_way), fine(kind));
        Scene with_mirror = scene;
        with_mirror.solids = {make_plane(Vec3d(0, -4, 0), Vec3d(0, 1, 0), mirror(Vec3d(0.5, 1, 0.25)))};
        CameraView view = one_pixel(mirrored, way);
        // The way to the mirror must not pass the cloud: begin beneath it.
        const double to_plane = (mirrored[1] + 4) / way[1];
        view = [&] {
            Camera camera;
            camera.projection = Projection::Orthographic;
            camera.position = mirrored - (to_plane + 0.5) * way;
            camera.look_at = mirrored;
            camera.up = Vec3d(0.1, 1, 0.3);
            ImageSize size;
            size.width = size.height = 1;
            return CameraView(camera, size);
        }();
        const Picture image(with_mirror, view, fine(kind));
        const double colour[3] = {0.5, 1, 0.25};
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(image.at("solid", c), colour[c] * (seen.at("", c) + seen.at("background", c)),
                        2e-4 * seen.at("", c))
                << name(kind);
    }
}

TEST(Solids, ShadowTheMedium)
{
    // A box that hides the sun from one half of a layer of cloud, whose edge lies between two voxels' centres. Seen
    // along the sun, a lit column has the closed form w0 p(-1) E (1 - T^2) / 2, and a hidden one none.
    Scene scene;
    const double w0 = 0.9, g = 0.3;
    scene.volumes.push_back(volume_of(cube(), medium(Vec3d(0.05), Vec3d(w0), g)));
    scene.lights = {make_sun(Vec3d(0, 1, 0))};
    scene.solids = {make_box(Vec3d(7.5, 40, -50), Vec3d(50, 41, 50), diffuse(Vec3d(0.0)))};
    light(scene);
    const double t = std::exp(-0.05 * 16), p = (1 - g) / (4 * pi * (1 + g) * (1 + g));
    const double lit = w0 * p * (1 - t * t) / 2;
    const auto at = [&](double x, Integrator kind) {
        Camera camera;
        camera.projection = Projection::Orthographic;
        camera.position = Vec3d(x, 30, 7.5);
        camera.look_at = Vec3d(x, 0, 7.5);
        camera.up = Vec3d(1, 0, 0);
        ImageSize size;
        size.width = size.height = 1;
        return Picture(scene, CameraView(camera, size), fine(kind)).at("direct_sun", 0);
    };
    for (const Integrator kind : integrators) {
        // Exact light at voxels; between them the depth is interpolated, and has kinks at the cube's faces: 2e-4.
        EXPECT_NEAR(at(3, kind), lit, 5e-4 * lit) << name(kind);
        EXPECT_EQ(at(12, kind), 0) << name(kind);
        // Between the two voxels that are seen and hidden the light falls linearly, and is one half at the edge.
        EXPECT_NEAR(at(7.5, kind), lit / 2, 2e-3 * lit) << name(kind);
        EXPECT_NEAR(at(7.25, kind), 0.75 * lit, 2e-3 * lit) << name(kind);
    }
}

TEST(Solids, AreShadowedByTheMedium)
{
    // A black cloud over a plane: the sun reaches it with exp(-tau), tau the column's.
    Scene scene;
    scene.volumes.push_back(volume_of(cube(), medium(Vec3d(0.02, 0.05, 0.1), Vec3d(0.0), 0)));
    scene.lights = {make_sun(Vec3d(0, 1, 0), Vec3d(1.0))};
    scene.solids = {make_plane(Vec3d(0, -4, 0), Vec3d(0, 1, 0), diffuse(Vec3d(0.4)))};
    light(scene);
    // Beneath the cloud, from a camera that looks below it.
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.position = Vec3d(5, -2, 8);
    camera.look_at = Vec3d(8, -4, 8);
    ImageSize size;
    size.width = size.height = 1;
    const CameraView view(camera, size);
    const double sigma[3] = {0.02, 0.05, 0.1};
    const Picture picture(scene, view, {});
    const Estimate path = traced(
        scene, 100, [&](int) { return view.ray(0.5, 0.5); }, [](const RayResult& r) { return r.solid; });
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(picture.at("solid", c), 0.4 / pi * std::exp(-16 * sigma[c]), 1e-7);
        EXPECT_NEAR(path.mean[c], 0.4 / pi * std::exp(-16 * sigma[c]), 1e-7);
    }
}

TEST(Solids, WhiteFurnaceIsExactInEachSampleOfPaths)
{
    // A white ball, box, plane, mirror and level set in and beside a medium without absorption under a uniform sky.
    Scene scene;
    scene.volumes.push_back(volume_of(cube(), medium(Vec3d(0.3), Vec3d(1.0), 0.6)));
    scene.sky = Sky::constant(Vec3d(1, 2, 3));
    scene.solids = {make_ball(Vec3d(8, 8, 8), 3, diffuse(Vec3d(1.0))),
                    make_level_set(level_set_ball(2, Vec3d(2, 2, 2), 0.25), diffuse(Vec3d(1.0))),
                    make_box(Vec3d(12, 2, 2), Vec3d(20, 4, 9), mirror(Vec3d(1.0))),
                    make_plane(Vec3d(0, -3, 0), Vec3d(0, 1, 0), diffuse(Vec3d(1.0)))};
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    int met = 0;
    for (int k = 0; k < 2000; ++k) {
        const double a = 2 * pi * uniform(hash_bits(5, uint64_t(k))), b = uniform(hash_bits(6, uint64_t(k)));
        const Vec3d way(std::cos(a) * 0.8, -0.6, std::sin(a) * 0.8);
        trace({Vec3d(16 * b, 8, 16 * (1 - b)) - 40 * way, way}, PathRandom(1, 0, 0, uint64_t(k)), r);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(everything(r)[c], c + 1, 1e-11) << k;
        met += r.solid[0] > 0;
    }
    EXPECT_GT(met, 1000) << "solids take part";
}

TEST(Solids, PicturesOfLightScatteredOnceAgreeWithPaths)
{
    // In a medium of small albedo pictures are those of light paths: glossy, mirrored, checkered and diffuse solids
    // that see each other and shadow the cloud. Twice-scattered light and the medium's light from the sky, which these
    // pictures lack, are below 1e-5 of the solids'.
    Scene scene;
    scene.volumes.push_back(volume_of(cube(), medium(Vec3d(0.05), Vec3d(1e-5), 0)));
    scene.lights = {make_sun(Vec3d(0.5, 1, 0.3), Vec3d(3, 2, 1)), make_lamp(Vec3d(8, 20, 8), Vec3d(900.0))};
    scene.background = scene.sky = Sky::constant(Vec3d(0.2, 0.3, 0.4));
    Material glossy = diffuse(Vec3d(0.9, 0.8, 0.7));
    glossy.finish = Finish::Glossy;
    glossy.roughness = 0.4;
    Material checkered = diffuse(Vec3d(0.2));
    checkered.checker = Vec3d(0.8, 0.6, 0.4);
    checkered.checker_edge = 3;
    scene.solids = {make_ball(Vec3d(8, 8, 8), 4, glossy), make_plane(Vec3d(0, -3, 0), Vec3d(0, 1, 0), checkered),
                    make_level_set(level_set_ball(3, Vec3d(1, 1, 14), 0.25), diffuse(Vec3d(0.5, 0.6, 0.7))),
                    make_box(Vec3d(16, -3, 2), Vec3d(18, 12, 14), mirror(Vec3d(0.9)))};
    light(scene);
    int compared = 0;
    for (const Vec3d& target : {Vec3d(8, 8, 8), Vec3d(1, 1, 14), Vec3d(3, -3, 3), Vec3d(16, 5, 8), Vec3d(12, -3, 12)}) {
        const CameraView view = one_pixel(target, Vec3d(0.6, -0.7, -0.4));
        IntegratorOptions many;
        many.solid_rays = sized(4000, 40000);
        many.shadow_rays = true;  // the edge of a solid's shadow in a light grid lies within half a voxel
        const Picture picture(scene, view, many);
        const Estimate path = traced(
            scene, sized(10000, 400000), [&](int) { return view.ray(0.5, 0.5); }, everything);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(picture.at("", c), path.mean[c], sigmas * path.error[c] + 3e-3 * path.mean[c]) << target << c;
            EXPECT_LT(path.error[c], 0.03 * path.mean[c]);
        }
        compared += picture.at("solid", 0) > 0;
    }
    EXPECT_EQ(compared, 5);
}

TEST(Solids, RefuseWhatIsNoSolid)
{
    const auto refused = [](const Solid& s) { return !sentence<InputError>([&] { check(s); }).empty(); };
    EXPECT_FALSE(refused(make_ball(Vec3d(0), 1)));
    EXPECT_TRUE(refused(make_ball(Vec3d(0), 0)));
    EXPECT_TRUE(refused(make_ball(Vec3d(0), std::nan(""))));
    EXPECT_TRUE(refused(make_box(Vec3d(0), Vec3d(1, 0, 1))));
    EXPECT_TRUE(refused(make_ball(Vec3d(0), 1, diffuse(Vec3d(0, 1.1, 0)))));
    Material rough;
    rough.roughness = -1;
    EXPECT_TRUE(refused(make_ball(Vec3d(0), 1, rough)));
    EXPECT_TRUE(refused(make_level_set(FloatGrid::create(0.0f)))) << "a background of 0";
    EXPECT_TRUE(refused(make_level_set(nullptr)));
    auto broken = level_set_ball(1, Vec3d(0), 0.25);
    broken->tree().setValueOn(openvdb::Coord(0), std::nanf(""));
    EXPECT_TRUE(refused(make_level_set(broken)));
}

}  // namespace
}  // namespace vdbcloud
