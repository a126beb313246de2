// What a solution says about its error: figures of the worst channel, and no figure that was not measured.
#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <map>

namespace vdbcloud {
namespace {

using Figures = std::map<std::string, double>;

Figures figures(const Accuracy& accuracy) { return {accuracy.figures.begin(), accuracy.figures.end()}; }

ScatterReport report_of(const std::vector<Light>& lights, double tolerance, int iterations)
{
    const auto grid = test::voxel_field(Vec3i(12), Vec3d(0.2), [](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) - Vec3d(5.5)) / 6;
        return std::max(0.0, 1 - x.dot(x));
    });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(1, 2, 8);
    medium.albedo = Vec3d(0.8, 0.9, 0.999);
    ScatterOptions options;
    options.solve.tolerance = tolerance;
    options.closure.iterations = iterations;
    options.closure.directions = 24;
    options.closure.change = 1e-9;
    options.reentry_rays = 2000;
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, medium, lights, options, {}, report);
    return report;
}

TEST(Accuracy, OfP1IsThatOfTheWorstChannel)
{
    const std::vector<Light> lights{make_sun(Vec3d(0.3, 1, 0.2))};
    const ScatterReport report = report_of(lights, 1e-4, 0);
    const Accuracy accuracy = accuracy_of(report, lights);
    Figures told = figures(accuracy);
    EXPECT_EQ(told.size(), 5u) << "no figure of sweeps: " << text_of(accuracy);
    EXPECT_TRUE(accuracy.left_out.empty());
    Figures worst;
    for (const ChannelReport& c : report.channel) {
        for (const auto& [name, value] : Figures{{"residual", c.solve.residual},
                                                 {"solver_error", c.solve.error},
                                                 {"defect", c.budget.defect},
                                                 {"faces_against_lines", std::abs(c.deposited / c.lines - 1)},
                                                 {"lost_at_voids", c.reentry}})
            worst[name] = std::max(worst[name], value);
    }
    EXPECT_EQ(told, worst);
    EXPECT_GT(told["residual"], 1e-9);
    EXPECT_LT(told["residual"], 1e-4) << "the tolerance";
    EXPECT_LT(figures(accuracy_of(report_of(lights, 1e-8, 0), lights))["residual"], 1e-8);
}

TEST(Accuracy, OfSweepsHasTheirLastChange)
{
    const std::vector<Light> lights{make_sun(Vec3d(0.3, 1, 0.2))};
    const ScatterReport report = report_of(lights, 1e-6, 4);
    Figures told = figures(accuracy_of(report, lights));
    double change = 0, contraction = 0;
    for (const ChannelReport& c : report.channel) {
        change = std::max(change, c.closure.change.back());
        contraction = std::max(contraction, c.closure.contraction);
    }
    EXPECT_EQ(told["change"], change);
    EXPECT_EQ(told["contraction"], contraction);
    EXPECT_GT(change, 0);
    EXPECT_EQ(told.count("faces_against_lines"), 1u);
}

TEST(Accuracy, SaysWhatALampLeavesOut)
{
    const std::vector<Light> lights{make_lamp(Vec3d(1.1, 1.1, 1.1))};
    const Accuracy accuracy = accuracy_of(report_of(lights, 1e-6, 0), lights);
    EXPECT_EQ(accuracy.left_out, std::vector<std::string>{lamp_cusp});
    EXPECT_EQ(figures(accuracy).count("faces_against_lines"), 0u) << "lines are of suns alone";
}

}  // namespace
}  // namespace vdbcloud
