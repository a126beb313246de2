// A sun with a disc lights collided light from all of its disc.
#include "scatter/fields.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// A dense wall that shades part of a thin slab behind it, so that the penumbra matters.
double wall_and_slab(const Vec3i& p)
{
    if (p.y() >= 14) return p.x() < 8 ? 4.0 : 0.0;
    return p.y() < 4 ? 0.5 : 0.0;
}

/// phi.
Vec3SGridPtr solved(const std::vector<Light>& lights, int iterations, int disc_samples = 16)
{
    const auto grid = test::voxel_field(Vec3i(16, 16, 8), Vec3d(0.2), wall_and_slab);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(2);
    medium.albedo = Vec3d(0.9);
    medium.phase = test::hg(0);
    ScatterOptions options;
    options.disc_samples = disc_samples;
    options.closure.iterations = iterations;
    options.closure.directions = 32;
    options.closure.change = 1e-6;
    options.solve.tolerance = 1e-9;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    return fluence(scatter_p1(*grid, nullptr, nullptr, medium, lights, options, {}, report));
}

/// ||a - sum of b|| / ||a||, first channel.
double difference(const Vec3SGrid& a, const std::vector<Vec3SGridPtr>& b)
{
    double difference = 0, size = 0;
    for (auto v = a.cbeginValueOn(); v; ++v) {
        double sum = 0;
        for (const auto& part : b) sum += double(part->tree().getValue(v.getCoord())[0]);
        difference += std::pow(double((*v)[0]) - sum, 2);
        size += std::pow(double((*v)[0]), 2);
    }
    return std::sqrt(difference / size);
}

class SunDisc : public testing::TestWithParam<int> {};

/// The equations are linear at g = 0: the disc's phi is the sum of those of its points. Tolerance: ten times that of
/// the solver, or of the sweeps' change.
TEST_P(SunDisc, PhiIsTheSumOverThePointsOfTheDisc)
{
    const int iterations = GetParam();
    constexpr int count = 5;
    const Vec3d to(0.3, 1, 0.1), irradiance(2, 2, 2);
    const Light disc = make_sun(to, irradiance, 30);
    std::vector<Vec3SGridPtr> parts;
    for (const auto& point : disc.points(count)) {
        const auto model_direction = point->common_direction();
        ASSERT_TRUE(model_direction);
        parts.push_back(solved({make_sun(*model_direction, irradiance / count)}, iterations));
    }
    const auto phi = solved({disc}, iterations, count);
    EXPECT_LT(difference(*phi, parts), iterations ? 1e-4 : 1e-6);
    const double as_point = difference(*phi, {solved({make_sun(to, irradiance)}, iterations)});
    EXPECT_GT(as_point, 0.02) << "the penumbra is seen";
}

/// Points are spread evenly over the disc, so that their sum converges: twice as many change less.
TEST(SunDiscPoints, PhiConvergesWithTheirNumber)
{
    const Light disc = make_sun(Vec3d(0.3, 1, 0.1), Vec3d(1.0), 30);
    const auto reference = solved({disc}, 0, 128);
    const double few = difference(*solved({disc}, 0, 4), {reference}),
                 many = difference(*solved({disc}, 0, 32), {reference});
    EXPECT_LT(many, few / 3);
    EXPECT_LT(many, 5e-3);
}

INSTANTIATE_TEST_SUITE_P(Method, SunDisc, testing::Values(0, 8),
                         [](const auto& of) { return std::string(of.param ? "Sweeps" : "P1"); });

}  // namespace
}  // namespace vdbcloud
