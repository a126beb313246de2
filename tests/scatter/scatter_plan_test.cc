// What multiple scattering would cost, against what a run counts.
#include "vdbcloud/scatter/scatter_plan.h"

#include "support/voxel_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

FloatGridPtr lumps(int n)
{
    return test::voxel_field(Vec3i(n), Vec3d(0.1), [](const Vec3i& p) {
        return std::max(0.0, std::sin(0.3 * p[0]) + std::sin(0.37 * p[1] + 1) + std::sin(0.41 * p[2] + 2) - 0.4);
    });
}

Medium cloud()
{
    Medium m;
    m.sigma_t_per_density = Vec3d(10);
    m.albedo = Vec3d(0.999);
    m.phase = PhaseFunction::henyey_greenstein(0.85);
    return m;
}

/// Says and counts, and compares: events but for iterations and products exactly.
void expect_as_said(const ScatterOptions& o, const std::vector<Light>& lights, const Medium& medium,
                    const std::string& what)
{
    const auto density = lumps(32);
    const ScatterPlan plan = scatter_plan(*density, nullptr, nullptr, medium, lights, o, true);
    ScatterReport report;
    scatter_p1(*density, nullptr, nullptr, medium, lights, o, {}, report);
    std::map<std::string, double> said = plan.work.events(), taken = report.work.events();
    for (const auto& [event, count] : taken) {
        // The number of iterations is that of clouds, within a whole number or two; taps are a mean.
        const double tolerance = event == "p1_iteration_voxel" ? 0.3 : event == "lattice_product" ? 0.1 : 1e-12;
        EXPECT_NEAR(said[event] / count, 1, tolerance) << what << ": " << event;
    }
    for (const auto& [event, count] : said) EXPECT_GT(taken.count(event), 0u) << what << ": " << event << " " << count;
    EXPECT_EQ(plan.voxels, 512.0 * double(report.blocks)) << what;
    // Of arrays the report has all but those of the results.
    EXPECT_GT(plan.bytes, 0.8 * double(report.bytes)) << what;
    EXPECT_LT(plan.bytes, 1.6 * double(report.bytes) + plan.grid_bytes) << what;
}

TEST(ScatterPlan, CountsTheSolvesOfChannelsThatDiffer)
{
    ScatterOptions o;
    o.reentry_rays = 2000;
    const Light white = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(2.0)), yellow = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(3, 2, 1));
    expect_as_said(o, {white}, cloud(), "one solution");
    expect_as_said(o, {yellow}, cloud(), "one solution in three strengths");
    o.sky = Sky::constant(Vec3d(0.1, 0.2, 0.3));
    expect_as_said(o, {white}, cloud(), "three solutions of one matrix");
    Medium coloured = cloud();
    coloured.albedo = Vec3d(0.999, 0.99, 0.9);
    expect_as_said(o, {white, yellow}, coloured, "three matrices");
    expect_as_said(o, {}, cloud(), "a sky alone");
}

TEST(ScatterPlan, CountsSweepsByDirectionsAndMoments)
{
    ScatterOptions o;
    o.reentry_rays = 0;
    o.closure.iterations = 3;
    o.closure.change = 1e-12;
    for (const int degree : {1, 3}) {
        o.closure.degree = degree;
        o.closure.directions = 16 * degree;
        expect_as_said(o, {make_sun(Vec3d(0.3, 1, 0.2))}, cloud(), "degree " + std::to_string(degree));
    }
    expect_as_said(o, {make_sun(Vec3d(0, 1, 0))}, cloud(), "light along an axis");
}

TEST(ScatterPlan, NeedsNoCountForMemory)
{
    const auto density = lumps(32);
    ScatterOptions o;
    o.closure.iterations = 2;
    const auto plan = [&](bool count) {
        return scatter_plan(*density, nullptr, nullptr, cloud(), {make_sun(Vec3d(0, 1, 0))}, o, count);
    };
    EXPECT_TRUE(plan(false).work.events().empty());
    EXPECT_EQ(plan(false).bytes, plan(true).bytes);
    EXPECT_EQ(scatter_plan(*test::voxel_field(Vec3i(4), Vec3d(1.0), [](const Vec3i&) { return 0.0; }), nullptr, nullptr,
                           cloud(), {}, o, true)
                  .bytes,
              0);
}

}  // namespace
}  // namespace vdbcloud
