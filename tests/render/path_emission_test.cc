// Emission and lamps within the medium, along light paths.
#include "render/path_estimates.h"
#include "vdbcloud/optics/optical_depth.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

const WorldRay oblique{Vec3d(-3, -2.1, -2.4), Vec3d(3, 2, 2.5).unit()};

/// factor * density as a grid of colours.
Vec3SGridPtr proportional(const FloatGrid& density, const Vec3d& factor)
{
    auto grid = Vec3SGrid::create(Vec3f(0));
    grid->setTransform(density.transform().copy());
    for (auto v = density.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), Vec3f(factor * double(*v)));
    return grid;
}

RayResult by_cells(const Scene& scene, const WorldRay& ray, int parts)
{
    IntegratorOptions how;
    how.shadow_rays = true;
    how.parts = parts;
    const PreparedScene prepared(scene, how);
    RayResult r;
    (*make_cells_integrator(prepared, how))(ray, r);
    return r;
}

TEST(PathEmission, WithoutExtinctionIsThatOfCellsInEachSample)
{
    Scene scene = one_clump(Vec3d(0), Vec3d(1), 0);
    scene.volumes[0].emission = proportional(*clump(14, 0.11, 3), Vec3d(1, 2, 0.5));
    const Vec3d expected = by_cells(scene, oblique, 1).emission;
    ASSERT_GT(expected[0], 0.01);
    const Estimate e = traced(scene, 20, oblique, [](const RayResult& r) { return r.emission; });
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(e.mean[c], expected[c], 1e-9 * expected[c]);
        EXPECT_LT(e.error[c], 1e-12 * expected[c]);
    }
}

TEST(PathEmission, BehindExtinctionIsThatOfCells)
{
    for (const Vec3d& sigma_t : {Vec3d(4), Vec3d(1, 3, 9)}) {
        Scene scene = one_clump(sigma_t, Vec3d(0.3), 0);
        scene.volumes[0].emission = proportional(*clump(14, 0.11, 3), Vec3d(1, 2, 0.5));
        const Vec3d expected = by_cells(scene, oblique, 8).emission;
        expect_mean(traced(scene, 20, oblique, [](const RayResult& r) { return r.emission; }), expected, 2e-4,
                    1e-4 * expected);
    }
}

TEST(PathEmission, KirchhoffsLawHoldsInTheMean)
{
    // Emission (1 - albedo) sigma_t B in a sky of radiance B: radiance B everywhere.
    for (const Vec3d& sigma_t : {Vec3d(6), Vec3d(2, 5, 9)}) {
        const Vec3d albedo(0.9, 0.5, 0.7), b(1, 2, 3);
        Scene scene = one_clump(sigma_t, albedo, 0.6);
        scene.volumes[0].emission = proportional(*scene.volumes[0].density, (Vec3d(1) - albedo) * sigma_t * b);
        scene.sky = Sky::constant(b);
        const Estimate e = traced(scene, sized(9000, 160000), oblique, [&](const RayResult& r) {
            Vec3d sum = r.multiple + r.emission;
            for (int c = 0; c < 3; ++c) sum[c] += std::exp(-r.tau[c]) * b[c];
            return sum;
        });
        expect_mean(e, b, 0.02);
    }
}

/// A place near the densest of clumps, so that light of a lamp there has much to scatter it.
Vec3d within(const FloatGrid& density)
{
    openvdb::Coord best;
    float most = 0;
    for (auto v = density.cbeginValueOn(); v; ++v)
        if (density.transform().indexToWorld(v.getCoord()).length() < 0.7 && *v > most) {
            most = *v;
            best = v.getCoord();
        }
    EXPECT_GT(most, 0.5);
    return density.transform().indexToWorld(best) + Vec3d(0.013, 0.02, -0.01);
}

/// Single scattering of a lamp along a ray, by the midpoint rule in the lamp's angle: no use of the library's sampling.
double lamp_by_quadrature(const FloatGrid& density, const Medium& m, const Vec3d& lamp, const WorldRay& ray)
{
    const double foot = (lamp - ray.origin).dot(ray.direction), d = (lamp - ray.at(foot)).length();
    constexpr int steps = 4000;
    double sum = 0;
    const auto accessor = density.getConstAccessor();
    for (int n = 0; n < steps; ++n) {
        const double angle = pi * ((n + 0.5) / steps - 0.5), t = foot + d * std::tan(angle);
        if (t < 0 || t > 12) continue;
        const Vec3d x = ray.at(t), to = lamp - x;
        const double rho = trilinear(accessor, density.transform().worldToIndex(x));
        if (rho == 0) continue;
        const double sigma_t = m.sigma_t_per_density[0],
                     tau = sigma_t * (integral_of_interpolant(density, ray, 0, t) +
                                      integral_of_interpolant(density, {x, to.unit()}, 0, to.length()));
        sum += sigma_t * m.albedo[0] * rho * m.phase(to.unit().dot(ray.direction)) * std::exp(-tau) * pi / (steps * d);
    }
    return sum;
}

TEST(PathLamp, WithinFogScattersOnceAsByQuadrature)
{
    // A lamp among the clumps, and rays that pass it at 0.3 and at a hundredth of a voxel. Quadrature errs by 1e-3.
    const Scene clumps_alone = one_clump(Vec3d(5), Vec3d(0.8), 0.5);
    const Vec3d lamp = within(*clumps_alone.volumes[0].density);
    for (const double miss : {0.3, 0.001}) {
        Scene scene = clumps_alone;
        scene.lights = {make_lamp(lamp)};
        const Vec3d w = Vec3d(1, 0.4, -0.3).unit(), aside = w.cross(Vec3d(0, 1, 0)).unit();
        const WorldRay ray{lamp + miss * aside - 4 * w, w};
        const double expected = lamp_by_quadrature(*scene.volumes[0].density, scene.volumes[0].medium, lamp, ray);
        expect_mean(traced(scene, 20000, ray, scattered_once), Vec3d(expected), 0.02, Vec3d(1e-3 * expected),
                    std::to_string(miss));
    }
}

TEST(PathLamp, AllPowerLeavesAConservativeMedium)
{
    // Power over all directions w and all rays of each: 4 pi times the lamp's intensity, scattered or not. A ray passes
    // the lamp at b, |b| uniform up to `reach`: radiance once scattered grows as 1 / |b|, so these rays leave no
    // variance of their own, and what remains has to be finite by the lamp's sampling.
    const Vec3d lamp = within(*clump(20, 0.1));
    const double reach = 2.8;
    for (const double g : {0.0, 0.7, -0.5})
        for (const Vec3d& sigma_t : {Vec3d(3), Vec3d(1, 2, 3)}) {
            if (g < 0 && sigma_t[0] < 3) continue;
            Scene scene = one_clump(sigma_t, Vec3d(1), g);
            scene.lights = {make_lamp(lamp)};
            const BrickMap map(*scene.volumes[0].density);
            const Estimate uncollided = estimate(20000, [&](int k) {
                const WorldRay ray{lamp, direction(uint64_t(k) + 3)};
                return attenuation(sigma_t * density_depth(map, ray, 0, 9));
            });
            const PathScene prepared(scene);
            PathTracer trace(prepared);
            RayResult r;
            const Estimate collided = estimate(sized(60000, 1000000), [&](int k) {
                const Vec3d w = direction(uint64_t(k) + 12345678);
                const double b = reach * uniform(hash_bits(61, uint64_t(k))),
                             a = 2 * pi * uniform(hash_bits(62, uint64_t(k)));
                const Vec3d x = (std::abs(w[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(w).unit();
                trace({lamp + b * (std::cos(a) * x + std::sin(a) * w.cross(x)) - 5 * w, w},
                      PathRandom(1, 0, 0, uint64_t(k)), r);
                return all_light(r) * (2 * pi * reach * b);
            });
            for (int c = 0; c < 3; ++c) {
                const double power = uncollided.mean[c] + collided.mean[c],
                             error = std::hypot(uncollided.error[c], collided.error[c]);
                EXPECT_NEAR(power, 1, sigmas * error) << g << ' ' << c;
                EXPECT_LT(error, 0.06) << g << ' ' << c;
                EXPECT_LT(uncollided.mean[c], 0.8) << g << ' ' << c;  // much is scattered
            }
        }
}

TEST(PathLamp, TwoLampsAreTheSumOfEach)
{
    Scene scene = one_clump(Vec3d(3, 6, 9), Vec3d(0.95), 0.6);
    const Light a = make_lamp(Vec3d(0.12, 0.15, 0.21), Vec3d(1, 2, 3)),
                b = make_lamp(Vec3d(0, 2, 1), Vec3d(4), "lamp1");
    const auto light = [&](const std::vector<Light>& lights, uint64_t seed) {
        scene.lights = lights;
        return traced(scene, sized(14000, 160000), oblique, all_light, seed);
    };
    const Estimate both = light({a, b}, 1), first = light({a}, 2), second = light({b}, 3);
    Vec3d error;
    for (int c = 0; c < 3; ++c) error[c] = std::hypot(first.error[c], second.error[c]);
    expect_mean(both, first.mean + second.mean, 0.03, error);
}

}  // namespace
}  // namespace vdbcloud
