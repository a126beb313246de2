// The parts of light paths by themselves: free paths, transmittance towards lights, points and directions near lamps.
#include "render/path_estimates.h"
#include "vdbcloud/optics/free_path.h"
#include "vdbcloud/render/light_sampling.h"

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

/// Numbers in [0, 1) in 32 bins against the uniform distribution. Chi-square of 31 degrees of freedom exceeds 80 with
/// probability 3e-6, and falls below 8 with 1e-6.
class Uniformity {
public:
    void add(double u) { ++bins_[size_t(std::clamp(u, 0.0, 1 - 1e-15) * 32)]; }
    void expect(const std::string& what) const
    {
        double count = 0, chi = 0;
        for (const double n : bins_) count += n;
        for (const double n : bins_) chi += (n - count / 32) * (n - count / 32) / (count / 32);
        EXPECT_LT(chi, 80) << what;
        EXPECT_GT(chi, 8) << what;
        EXPECT_GT(count, 3000) << what;
    }

private:
    std::array<double, 32> bins_{};
};

WorldRay crossing(int k)
{
    const Vec3d w = direction(uint64_t(k) + 77);
    Vec3d at;
    for (int a = 0; a < 3; ++a) at[a] = 1.2 * (uniform(hash_bits(9, uint64_t(k), uint64_t(a))) - 0.5);
    return {at - 3 * w, w};
}

TEST(FreePath, TravelInvertsTheIntegralOfTheInterpolant)
{
    const auto grid = clump(20, 0.1);
    const BrickMap map(*grid);
    int reached = 0;
    for (int k = 0; k < 300; ++k) {
        const WorldRay ray = crossing(k);
        const double whole = integral_of_interpolant(*grid, ray, 0, 9);
        for (const double part : {1e-9, 0.3, 0.999, 1.001}) {
            const Travel way = travel(map, IndexRay(map.index_from_world(), ray), 0, 9, part * whole);
            EXPECT_EQ(way.reached, part < 1 && whole > 0);
            if (!way.reached) {
                EXPECT_NEAR(way.depth, whole, 1e-11);
                EXPECT_EQ(way.t, 9);
                continue;
            }
            ++reached;
            EXPECT_NEAR(integral_of_interpolant(*grid, ray, 0, way.t), part * whole, 1e-10 * (0.01 + whole));
            EXPECT_NEAR(way.density, trilinear(grid->getConstAccessor(), grid->transform().worldToIndex(ray.at(way.t))),
                        1e-9);
        }
    }
    EXPECT_GT(reached, 500);
}

TEST(FreePath, TravelSolvesCellsThatBeginEmpty)
{
    // A ramp from 0: the density is linear in t and the depth t^2 / 2, whose inverse has no slope at 0.
    const auto grid = box({3, 3, 3}, 1, [](openvdb::Coord ijk) { return double(ijk[0]); });
    const BrickMap map(*grid);
    const WorldRay ray{Vec3d(0, 1, 1), Vec3d(1, 0, 0)};
    for (const double depth : {1e-14, 1e-6, 0.3, 1.9}) {
        const Travel way = travel(map, IndexRay(map.index_from_world(), ray), 0, 2, depth);
        EXPECT_TRUE(way.reached);
        EXPECT_NEAR(way.t, std::sqrt(2 * depth), 1e-12 + 1e-8 * std::sqrt(depth));
    }
}

/// Three volumes on the way, one of them coloured, thin enough for each to be the first.
Scene three_clumps()
{
    Scene scene = one_clump(Vec3d(0.5, 1, 2), Vec3d(1), 0);
    scene.volumes.push_back(volume_of(clump(14, 0.13, 5, Vec3d(0.3, 0, 0)), medium(Vec3d(0.75), Vec3d(1), 0)));
    scene.volumes.push_back(volume_of(clump(16, 0.12, 7, Vec3d(0, 0.2, 0)), medium(Vec3d(1), Vec3d(1), 0)));
    return scene;
}

/// 1 - exp(-tau) of channel c over [0, t], by the tests' own integral.
double law(const Scene& scene, const WorldRay& ray, int c, double t)
{
    double tau = 0;
    for (const Volume& v : scene.volumes)
        tau += v.medium.sigma_t_per_density[c] * integral_of_interpolant(*v.density, ray, 0, t);
    return -std::expm1(-tau);
}

/// The probability that the first collision on a ray is one with volume v, by the midpoint rule: errs by 1e-3.
double probability_of(const Scene& scene, const WorldRay& ray, int c, size_t v)
{
    constexpr int steps = 150;
    constexpr double first = 0.8, step = 4.4 / steps;  // around the clumps
    std::vector<FloatGrid::ConstAccessor> densities;
    for (const Volume& volume : scene.volumes) densities.push_back(volume.density->getConstAccessor());
    double tau = 0, sum = 0;
    for (int n = 0; n < steps; ++n) {
        double sigma_t = 0, own = 0;
        for (size_t k = 0; k < scene.volumes.size(); ++k) {
            const Volume& volume = scene.volumes[k];
            const Vec3d at = volume.density->transform().worldToIndex(ray.at(first + (n + 0.5) * step));
            const double here = volume.medium.sigma_t_per_density[c] * trilinear(densities[k], at);
            sigma_t += here;
            if (k == v) own = here;
        }
        sum += own * step * std::exp(-tau - sigma_t * step / 2);
        tau += sigma_t * step;
    }
    return sum;
}

TEST(FreePath, CollisionsFollowTheExponentialLaw)
{
    const Scene scene = three_clumps();
    const PathScene prepared(scene);
    PathMedia media(prepared);
    for (const bool surely : {false, true})
        for (const int c : {0, 2}) {
            Uniformity lengths;
            double in_second = 0, expected_in_second = 0, variance = 0, collided = 0, expected = 0, spread = 0;
            std::vector<double> depths;
            for (int k = 0; k < sized(5000, 40000); ++k) {
                const WorldRay ray = crossing(k);
                const double whole = law(scene, ray, c, 9);
                if (!(whole > 0)) continue;
                media.set(ray);
                media.depths(depths);
                PathRandom random(5, 0, 0, uint64_t(k));
                Collision hit;
                const bool collides =
                    surely ? media.collide_surely(c, depths, random, hit) : media.collide(c, random, hit);
                const double share = probability_of(scene, ray, c, 1) / (surely ? whole : 1);
                expected_in_second += share;
                variance += share * (1 - share);
                expected += surely ? 1 : whole;
                spread += surely ? 0 : whole * (1 - whole);
                if (!collides) continue;
                ++collided;
                lengths.add(law(scene, ray, c, hit.t) / whole);
                in_second += double(hit.volume == 1);
                EXPECT_NEAR(hit.density, media.density(hit.volume, hit.t), 1e-6);
            }
            lengths.expect("channel " + std::to_string(c) + (surely ? ", surely" : ""));
            EXPECT_NEAR(in_second, expected_in_second, sigmas * std::sqrt(variance) + 1e-3 * in_second);
            EXPECT_NEAR(collided, expected, sigmas * std::sqrt(spread) + 1e-6);
            EXPECT_GT(variance, 100);
        }
}

TEST(NullCollisions, DepthThroughUniformBricksIsTheIntegralOfTheInterpolant)
{
    // Density 0.7 within, clumps about; 4^3 of the bricks are uniform. Bricks that do not align with the box, too.
    const auto grid = box({56, 56, 56}, 0.05, [](openvdb::Coord ijk) {
        const bool within = ijk[0] > 9 && ijk[1] > 9 && ijk[2] > 9 && ijk[0] < 46 && ijk[1] < 46 && ijk[2] < 46;
        return within ? 0.7 : clumps(ijk, 3, 1);
    });
    const BrickMap map(*grid);
    const NullCollisions medium(map);
    for (int k = 0; k < 100; ++k) {
        WorldRay ray = crossing(k);
        ray.origin += Vec3d(1.4);
        const IndexRay index(map.index_from_world(), ray);
        const double whole = integral_of_interpolant(*grid, ray, 0, 9),
                     part = integral_of_interpolant(*grid, ray, 2.1, 2.9);
        EXPECT_NEAR(medium.depth_up_to(index, 0, 9, 1e9), whole, 1e-10 * (1 + whole)) << k;
        EXPECT_NEAR(medium.depth_up_to(index, 2.1, 2.9, 1e9), part, 1e-10) << k;
        EXPECT_GT(whole, 0.2);
        EXPECT_GT(medium.depth_up_to(index, 0, 9, 0.5 * whole), 0.5 * whole);
    }
}

TEST(PathMedia, TransmittanceHasTheRightMeanBeyondRoulette)
{
    Scene scene = one_clump(Vec3d(40, 50, 60), Vec3d(1), 0);
    scene.volumes.push_back(volume_of(clump(14, 0.13, 5, Vec3d(0.3, 0, 0)), medium(Vec3d(3), Vec3d(1), 0)));
    const PathScene prepared(scene);
    PathMedia media(prepared);
    int deep = 0;
    for (int k = 0; k < 40; ++k) {
        media.set(crossing(k));
        const Vec3d exact = attenuation(media.optical_depth(0, 9));
        const Estimate e = estimate(5000, [&](int n) {
            PathRandom random(7, k, 0, uint64_t(n));
            return media.transmittance(9, random);
        });
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(e.mean[c], exact[c], sigmas * std::max(e.error[c], 0.3 / 5000) + 1e-12) << k;
        deep += exact[0] < 0.2 && exact[0] > 1e-4;
        if (exact[0] >= 0.3) {
            EXPECT_LT(e.error[0], 1e-12);  // exact where light is bright
        }
    }
    EXPECT_GE(deep, 2);
}

TEST(LightSampling, EqualAnglesHaveTheirDensity)
{
    for (const auto& [t0, t1, lamp] :
         {std::tuple{0.5, 4.0, Vec3d(2, 0.3, 0)}, {0.0, 1.0, Vec3d(5, 0.01, 0)}, {1.0, 7.0, Vec3d(-1, 2, 1)}}) {
        const EquiangularSampler points({Vec3d(0), Vec3d(1, 0, 0)}, lamp, t0, t1);
        double sum = 0;
        Uniformity law;
        // The midpoint rule in t, and the distribution of samples by its running sum.
        constexpr int steps = 40000;
        std::vector<double> below{0};
        for (int n = 0; n < steps; ++n) {
            sum += points.density(t0 + (t1 - t0) * (n + 0.5) / steps) * (t1 - t0) / steps;
            below.push_back(sum);
        }
        EXPECT_NEAR(sum, 1, 1e-4);
        EXPECT_EQ(points.density(t1 + 0.1), 0);
        for (int k = 0; k < sized(5000, 40000); ++k) {
            const double t = points.sample(uniform(hash_bits(3, uint64_t(k))));
            ASSERT_GE(t, t0);
            ASSERT_LE(t, t1);
            law.add(below[size_t((t - t0) / (t1 - t0) * steps)]);
        }
        law.expect("equal angles");
    }
}

TEST(LightSampling, DirectionsNearALampHaveTheirDensity)
{
    const Vec3d to_lamp = Vec3d(0.3, -0.8, 0.5).unit();
    Uniformity angle, azimuth;
    const Vec3d x = to_lamp.cross(Vec3d(1, 0, 0)).unit(), y = to_lamp.cross(x);
    for (int k = 0; k < sized(5000, 40000); ++k) {
        const Vec3d w =
            direction_near_lamp(to_lamp, uniform(hash_bits(1, uint64_t(k))), uniform(hash_bits(2, uint64_t(k))));
        EXPECT_NEAR(w.length(), 1, 1e-12);
        angle.add(std::acos(std::clamp(w.dot(to_lamp), -1.0, 1.0)) / pi);
        azimuth.add(std::atan2(w.dot(y), w.dot(x)) / (2 * pi) + 0.5);
    }
    angle.expect("angle");
    azimuth.expect("azimuth");
    // Uniform in the angle a: the density per solid angle is 1 / (pi 2 pi sin a).
    for (const double a : {0.1, 1.0, 2.5})
        EXPECT_NEAR(density_near_lamp(to_lamp, std::cos(a) * to_lamp + std::sin(a) * x),
                    1 / (2 * pi * pi * std::sin(a)), 1e-9);
}

TEST(LightSampling, PhaseFunctionsSampleTheirValues)
{
    for (const PhaseFunction& p :
         {PhaseFunction("rayleigh"), PhaseFunction::henyey_greenstein(0.85), PhaseFunction("hg-draine", {20}),
          PhaseFunction("double-henyey-greenstein", {0.8, -0.3, 0.7})}) {
        // The cumulative distribution of the cosine, by the midpoint rule on a fine scale towards +1.
        constexpr int steps = 200000;
        std::vector<double> below{0};
        const auto cosine = [](double s) { return 1 - 2 * (1 - s) * (1 - s) * (1 - s); };
        for (int n = 0; n < steps; ++n) {
            const double c0 = cosine(double(n) / steps), c1 = cosine((n + 1.0) / steps);
            below.push_back(below.back() + 2 * pi * p((c0 + c1) / 2) * (c1 - c0));
        }
        EXPECT_NEAR(below.back(), 1, 1e-3) << p.text();
        Uniformity law;
        const Vec3d w = Vec3d(1, 2, -2) / 3;
        for (int k = 0; k < 20000; ++k) {
            PathRandom random(1, 2, 3, uint64_t(k));
            const double u = random.next(), v = random.next();
            const double s = 1 - std::cbrt((1 - std::clamp(w.dot(p.sample(w, u, v)), -1.0, 1.0)) / 2);
            law.add(below[size_t(std::clamp(s, 0.0, 1.0) * steps)] / below.back());
        }
        law.expect(p.text());
    }
}

}  // namespace
}  // namespace vdbcloud
