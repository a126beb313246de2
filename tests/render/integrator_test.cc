// What a camera sees, against closed forms that hold for any density, and the integrators against each other.
#include "vdbcloud/render/integrator.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/phase_function.h"

#include "support/fields.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

Medium medium(double sigma_t, double albedo = 1, double g = 0)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    m.albedo = Vec3d(albedo);
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

/// A scene of one grid and one sun.
Scene sunlit(const FloatGridPtr& density, const Medium& m, const Vec3d& to_sun, const TransmittanceOptions& light = {})
{
    Scene scene;
    const Light sun = make_sun(to_sun, Vec3d(2, 3, 5));
    scene.lights.push_back(sun);
    Volume volume;
    volume.density = density;
    volume.medium = m;
    volume.transmittance.push_back(transmittance_grid(*density, m, sun, light));
    scene.volumes.push_back(volume);
    return scene;
}

/// An orthographic view of `grid` along `direction`, n x n pixels.
CameraView view_along(const FloatGrid& grid, const Vec3d& direction, int n)
{
    const auto bounds = grid.evalActiveVoxelBoundingBox();
    const auto& t = grid.transform();
    const Vec3d lo = t.indexToWorld(bounds.min().asVec3d()), hi = t.indexToWorld(bounds.max().asVec3d());
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.look_at = (lo + hi) / 2;
    camera.width = 0.8 * (hi - lo).length();
    camera.position = camera.look_at - 2 * (hi - lo).length() * direction.unit();
    camera.up = Vec3d(0.1, 1, 0.3);
    ImageSize size;
    size.width = size.height = n;
    return {camera, size};
}

Film render(const Scene& scene, const CameraView& view, const IntegratorOptions& options = {},
            RenderCost* cost = nullptr)
{
    Film film(view.size(), render_layers(scene, {"all"}));
    const auto took = render_image(film, scene, view, {}, options);
    if (cost) *cost = took;
    return film;
}

/// A cloud of clumps and holes, the same at any resolution.
FloatGridPtr cloud(int n, double h = 1)
{
    return box({n, n, n}, h, [n](Coord ijk) {
        const Vec3d p = (Vec3d(ijk[0], ijk[1], ijk[2]) + Vec3d(0.5)) * (40.0 / n);
        return std::max(0.0, std::sin(0.4 * p[0]) + std::sin(0.37 * p[1] + 1) + std::sin(0.43 * p[2] + 2) +
                                 std::sin(0.2 * (p[0] + p[1] - p[2])) - 0.2);
    });
}

/// The largest relative deviation from expected(T) over pixels whose optical depth is in [1e-3, 20].
template<typename F>
double worst(const Film& film, F expected)
{
    const int direct = film.offset(film.find("direct_sun")), t = film.offset(film.find("transmittance"));
    double error = 0;
    int counted = 0;
    for (int j = 0; j < film.size().height; ++j)
        for (int i = 0; i < film.size().width; ++i) {
            const float* pixel = film.pixel(i, j);
            const double T = pixel[t], tau = -std::log(std::max(T, 1e-30));
            if (tau < 1e-3 || tau > 20) continue;
            ++counted;
            for (int c = 0; c < 3; ++c) error = std::max(error, std::abs(pixel[direct + c] / expected(T, c) - 1));
        }
    EXPECT_GT(counted, film.size().width * film.size().height / 10);
    return error;
}

const double irradiance[3] = {2, 3, 5};

// Both identities hold for the continuous medium whatever its density. Ours differ from them by the light grid's
// interpolation alone: the largest of depths' second differences over a voxel, of order (sigma_t h)^2 here.
double sun_behind_error(const FloatGridPtr& density, double sigma_t, const Vec3d& to_sun, const TransmittanceOptions& o)
{
    const Medium m = medium(sigma_t, 0.9, 0.4);
    const auto film = render(sunlit(density, m, to_sun, o), view_along(*density, -to_sun, 48));
    return worst(film, [&](double T, int c) { return 0.9 * m.phase(-1) * irradiance[c] * (1 - T * T) / 2; });
}

double sun_ahead_error(const FloatGridPtr& density, double sigma_t, const Vec3d& to_sun, const TransmittanceOptions& o)
{
    const Medium m = medium(sigma_t, 0.9, 0.4);
    const auto film = render(sunlit(density, m, to_sun, o), view_along(*density, to_sun, 48));
    return worst(film, [&](double T, int c) { return 0.9 * m.phase(1) * irradiance[c] * -std::log(T) * T; });
}

/// A random fractal cloud, rough down to the voxel: noise of spectral exponent 11/3 above its threshold, at most 1.
FloatGridPtr fractal_cloud(int n)
{
    Spectrum spectrum;
    spectrum.seed = 5;
    const auto noise = synthesize(Vec3i(n), Vec3d(1), spectrum);
    return box({n, n, n}, 1,
               [&](Coord ijk) { return std::clamp(0.4 * double(noise(ijk[0], ijk[1], ijk[2])), 0.0, 1.0); });
}

TEST(Integrator, HasHalfOfOneMinusTSquaredWithTheSunBehind)
{
    // Light along an axis: the depths of the interpolant are bilinear across it, so the light grid is exact there, and
    // along it errs by sigma_t h / 8 times density's change over a voxel, which cancels over the ray.
    for (const Vec3d& to_sun : {Vec3d(0, 1, 0), Vec3d(-1, 0, 0)})
        EXPECT_LT(sun_behind_error(fractal_cloud(64), 0.02, to_sun, {}), 1e-4) << to_sun;
}

TEST(Integrator, HasTauTimesTLookingIntoTheSun)
{
    for (const Vec3d& to_sun : {Vec3d(0, 1, 0), Vec3d(0, 0, 1)})
        EXPECT_LT(sun_ahead_error(fractal_cloud(64), 0.02, to_sun, {}), 1e-4) << to_sun;
}

TEST(Integrator, MeetsTheIdentitiesAtSecondOrderInTheLightGridsSpacing)
{
    // An oblique sun on a rough and thick cloud: the error is the interpolation of depths between light-grid points.
    const Vec3d to_sun(0.3, 1, 0.2);
    const auto density = fractal_cloud(24);
    double error[3], ahead[3];
    for (int k = 0; k < 3; ++k) {
        TransmittanceOptions o{Fidelity::Exact};
        o.refine = 1 << k;
        error[k] = sun_behind_error(density, 0.25, to_sun, o);
        ahead[k] = sun_ahead_error(density, 0.25, to_sun, o);
    }
    EXPECT_GT(std::log2(error[0] / error[2]) / 2, 1.8);
    EXPECT_GT(std::log2(ahead[0] / ahead[2]) / 2, 1.8);
}

TEST(Integrator, HasTheClosedFormOfACubeSeenFromItsSide)
{
    // Side view at depth d below the top: w0 p(90) E (1 - exp(-tau)) exp(-sigma d). In the voxel where density ramps to
    // 0 at the side the light has a shorter way, a term of first order in h: 5e-3 of the brightest at 128.
    const int n = 128;
    const double h = 1.0 / n, sigma = 4;
    const auto cube = box({n, n, n}, h, [](Coord) { return 1.0; });
    const auto scene = sunlit(cube, medium(sigma, 0.8, 0.3), {0, 1, 0});
    const auto view = view_along(*cube, {0, 0, -1}, 64);
    Camera camera = view.camera();
    camera.up = Vec3d(0, 1, 0);
    const CameraView upright(camera, view.size());
    const auto film = render(scene, upright);
    const int direct = film.offset(film.find("direct_sun"));
    int counted = 0;
    for (int j = 0; j < 64; ++j) {
        const double y = upright.ray(32, j + 0.5).origin[1],
                     d = (n - 0.5) * h - y;  // the top is half a voxel above the last centre
        if (d < 0.05 || d > 0.95) continue;
        ++counted;
        const double brightest = 0.8 * medium(1, 1, 0.3).phase(0) * 2 * (1 - std::exp(-sigma));
        EXPECT_NEAR(film.pixel(32, j)[direct] / brightest, std::exp(-sigma * d), 5e-3) << "at depth " << d;
    }
    EXPECT_GT(counted, 30);
}

TEST(Integrator, HasTheEmissionOfAFlameWithoutSmoke)
{
    Scene scene;
    Volume volume;
    volume.density = openvdb::FloatGrid::create(0.0f);
    volume.medium = medium(1);
    volume.emission = openvdb::Vec3SGrid::create(Vec3f(0));
    volume.emission->fill(openvdb::CoordBBox(Coord(0, 0, 0), Coord(7, 7, 7)), Vec3f(0, 3, 0));
    volume.emission->tree().voxelizeActiveTiles();
    scene.volumes.push_back(volume);
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.position = Vec3d(3.5, 3.5, 50);
    camera.look_at = Vec3d(3.5, 3.5, 3.5);
    camera.width = 1;
    ImageSize one;
    one.width = one.height = 1;
    const auto film = render(scene, {camera, one});
    EXPECT_NEAR(film.pixel(0, 0)[1], 3.0 * 8, 1e-5);  // ramps of half a voxel's worth at both ends
    EXPECT_EQ(film.pixel(0, 0)[3], 0);
}

TEST(Integrator, MultipliesTheBackgroundByTheTransmittance)
{
    const auto density = cloud(32);
    auto scene = sunlit(density, medium(0.05), {0, 1, 0});
    scene.background = Sky::constant({1, 2, 3});
    const auto film = render(scene, view_along(*density, {1, 0.2, 0.4}, 32));
    const int b = film.offset(film.find("background")), t = film.offset(film.find("transmittance"));
    for (int j = 0; j < 32; j += 5)
        for (int i = 0; i < 32; i += 5)
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(film.pixel(i, j)[b + c], (c + 1) * film.pixel(i, j)[t], 1e-6);
}

/// Largest difference of the beauty, over the mean of it.
double difference(const Film& a, const Film& b)
{
    double largest = 0, mean = 0;
    for (int j = 0; j < a.size().height; ++j)
        for (int i = 0; i < a.size().width; ++i)
            for (int c = 0; c < 3; ++c) {
                largest = std::max(largest, double(std::abs(a.pixel(i, j)[c] - b.pixel(i, j)[c])));
                mean += a.pixel(i, j)[c] / (3.0 * a.size().width * a.size().height);
            }
    EXPECT_GT(mean, 0);
    return largest / mean;
}

TEST(Integrator, ConvergesToOnePictureWithAllThreeRules)
{
    const auto density = cloud(24);
    auto scene = sunlit(density, medium(0.1, 0.9, 0.5), {0.3, 1, 0.2});
    const auto view = view_along(*density, {1, -0.2, 0.4}, 16);
    IntegratorOptions fine, steps, romberg;
    fine.parts = 64;
    const auto truth = render(scene, view, fine);
    steps.kind = Integrator::Steps;
    steps.step = 0.5;
    const double half = difference(render(scene, view, steps), truth);
    steps.step = 0.125;
    const double eighth = difference(render(scene, view, steps), truth);
    EXPECT_GT(std::log2(half / eighth) / 2, 1.5) << half << " " << eighth;  // kinks keep it from a clean 2
    romberg.kind = Integrator::Romberg;
    romberg.tolerance = 1e-3;
    const double loose = difference(render(scene, view, romberg), truth);
    romberg.tolerance = 1e-5;
    const double tight = difference(render(scene, view, romberg), truth);
    EXPECT_LT(loose, 3e-2);
    EXPECT_LT(tight, 1e-3);
    double before = 0;
    for (const int parts : {1, 2, 4}) {  // fourth order in the part
        IntegratorOptions o;
        o.parts = parts;
        const double error = difference(render(scene, view, o), truth);
        if (parts == 1) {
            EXPECT_LT(error, 1e-2);
        } else {
            EXPECT_GT(before / error, 8) << parts << " parts: " << error;
        }
        before = error;
    }
}

TEST(Integrator, ConvergesToShadowRaysAtSecondOrderInTheGrid)
{
    const auto density = cloud(32);
    auto scene = sunlit(density, medium(0.05), {0.3, 1, 0.2}, {Fidelity::Exact});
    const auto view = view_along(*density, {1, -0.2, 0.4}, 16);
    IntegratorOptions rays;
    rays.shadow_rays = true;
    // What differs is the interpolation of depths between light-grid points: order 2 in their spacing.
    const auto truth = render(scene, view, rays);
    const double one = difference(render(scene, view), truth);
    TransmittanceOptions fine{Fidelity::Exact};
    fine.refine = 4;
    const double four = difference(render(sunlit(density, medium(0.05), {0.3, 1, 0.2}, fine), view), truth);
    EXPECT_LT(one, 0.1);
    EXPECT_GT(std::log2(one / four) / 2, 1.7) << one << " " << four;
}

TEST(Integrator, HasThePictureOfTheGeneralPathOnThePlainPath)
{
    const auto density = fractal_cloud(40);
    const auto scene = sunlit(density, medium(0.8, 0.9, 0.3), {0.3, 1, 0.2});
    const auto view = view_along(*density, {1, -0.2, 0.4}, 40);
    IntegratorOptions general;
    general.plain_path = false;
    const auto a = render(scene, view), b = render(scene, view, general);
    EXPECT_LT(difference(a, b), 1e-6);  // the same sums in another order, as floats
    const int z = a.offset(a.find("Z")), t = a.offset(a.find("transmittance"));
    for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i) {
            EXPECT_NEAR(a.pixel(i, j)[z] / b.pixel(i, j)[z], 1, 1e-5);
            EXPECT_NEAR(a.pixel(i, j)[t], b.pixel(i, j)[t], 1e-6);
        }
}

TEST(Integrator, HasTheSamePictureOfAScaledTurnedMovedScene)
{
    const auto plain = cloud(32);
    const auto moved = plain->deepCopy();
    auto transform = openvdb::math::Transform::createLinearTransform(0.01);
    transform->postRotate(0.8, openvdb::math::X_AXIS);
    transform->postRotate(-2.1, openvdb::math::Z_AXIS);
    transform->postTranslate(Vec3d(3, -5, 1));
    moved->setTransform(transform);
    const auto turn = [&](const Vec3d& v) {
        return (transform->indexToWorld(v) - transform->indexToWorld(Vec3d(0))) / 0.01;
    };
    const Vec3d to_sun(0.3, 1, 0.2), direction(1, -0.3, 0.4);
    const auto view = view_along(*plain, direction, 24);
    Camera camera = view.camera();
    camera.position = transform->indexToWorld(camera.position);
    camera.look_at = transform->indexToWorld(camera.look_at);
    camera.up = turn(camera.up);
    camera.width *= 0.01;
    const auto a = render(sunlit(plain, medium(0.05), to_sun), view);
    const auto b = render(sunlit(moved, medium(5), turn(to_sun)), CameraView(camera, view.size()));
    EXPECT_LT(difference(a, b), 1e-4);  // single precision in the light grid
}

TEST(Integrator, HasTheTransmittanceFromInsideACloudAndNoneOfAnEmptyScene)
{
    const auto density = box({32, 32, 32}, 1, [](Coord) { return 1.0; });
    const auto scene = sunlit(density, medium(0.1), {0, 1, 0});
    Camera camera;
    camera.position = Vec3d(15.5, 15.5, 15.5);
    camera.look_at = Vec3d(15.5, 15.5, 0);
    ImageSize size;
    size.width = size.height = 1;
    const auto film = render(scene, {camera, size});
    // 16 voxels of density 1 between the eye and the ramp's middle.
    EXPECT_NEAR(film.pixel(0, 0)[film.offset(film.find("transmittance"))], std::exp(-1.6), 1e-6);
    const auto empty = openvdb::FloatGrid::create(0.0f);
    const auto nothing = render(sunlit(empty, medium(1), {0, 1, 0}), {camera, size});
    EXPECT_EQ(nothing.pixel(0, 0)[3], 0);
}

TEST(Integrator, HasEqualBitsForOneAndTwoThreads)
{
    const auto density = cloud(32);
    const auto scene = sunlit(density, medium(0.05), {0.3, 1, 0.2});
    const auto view = view_along(*density, {1, -0.2, 0.4}, 40);
    const auto run = [&](int threads) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
        return render(scene, view);
    };
    EXPECT_EQ(difference(run(1), run(2)), 0);
}

TEST(Integrator, RefusesUnknownLayersAndRules)
{
    EXPECT_THROW(render_layers({}, {"beauty"}), UsageError);
    EXPECT_THROW(integrator_kind("simpson"), InputError);
}

}  // namespace
}  // namespace vdbcloud
