// p1solve as a user runs it: budgets against lines, what is lost across voids, the series read back from its file,
// refusals.
#include "support/run.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/scatter/series_grids.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbcloud {
namespace {

using test::program;
using Words = std::vector<std::string>;

class P1Solve : public testing::Test {
protected:
    /// A density that is 1 where `inside`, of edge 1 / n.
    std::string density(const std::string& name, const Vec3i& size, double h,
                        const std::function<bool(const Vec3i&)>& inside)
    {
        const auto grid = test::voxel_field(size, Vec3d(h), [&](const Vec3i& p) { return inside(p) ? 1.0 : 0.0; });
        grid->setName("density");
        grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        GridFile file;
        file.grids.push_back(grid);
        file.metadata = std::make_shared<MetaMap>();
        write_grid_file(scratch / name, file);
        return scratch / name;
    }
    std::string slab(int n)
    {
        return density("slab.vdb", Vec3i(8, n, 8), 1.0 / n, [](const Vec3i&) { return true; });
    }

    /// The report of a run that must end well.
    nlohmann::json solve(const std::string& input, const Words& options, int status = 0)
    {
        Words words{program("p1solve"), input,  "-o", scratch / "out.vdb", "--json", scratch / "out.json",
                    "--reentry-rays",   "20000"};
        words.insert(words.end(), options.begin(), options.end());
        result = test::run(words);
        EXPECT_EQ(result.status, status) << result.err;
        return nlohmann::json::parse(test::read_text(scratch / "out.json"), nullptr, false);
    }
    /// Mean of one channel of phi over the voxels of the density.
    double mean_phi(const std::string& path, const std::function<bool(const openvdb::Coord&)>& where)
    {
        const GridFile file = read_grid_file(path);
        const auto phi = fluence(read_collided_light(file, PhaseFunction(), {}));
        const auto rho = openvdb::gridPtrCast<openvdb::FloatGrid>(find_grid(file, "density"));
        if (!phi || !rho) return std::nan("");
        double sum = 0;
        int count = 0;
        for (auto v = rho->cbeginValueOn(); v; ++v)
            if (*v > 0 && where(v.getCoord())) {
                sum += double(phi->tree().getValue(v.getCoord())[0]);
                ++count;
            }
        return sum / count;
    }

    test::Scratch scratch;
    test::RunResult result;
};

TEST_F(P1Solve, BudgetOfASlabClosesAndAgreesWithLinesTo1e6)
{
    const std::string input = slab(32);
    for (const char* g : {"0", "0.85"}) {
        const auto j = solve(input, {"--extinction", "8", "--albedo", "0.99", "--g", g, "--sun", "0.5,1,0",
                                     "--periodic", "xz", "--tolerance", "1e-8"});
        const auto& budget = j["channels"]["r"]["budget"];
        const double in = budget["beam_lost_in_medium"];
        EXPECT_GT(in, 0.05);  // of 0.056 that meet the period of a quarter by a quarter
        EXPECT_LT(std::abs(double(budget["faces_against_lines"])), 1e-6);
        EXPECT_LT(double(budget["defect"]), 1e-6);
        EXPECT_NEAR(double(budget["reflected"]) + double(budget["transmitted_diffuse"]) + double(budget["absorbed"]),
                    in, 1e-6 * in);
        EXPECT_GT(double(budget["absorbed"]), 0.01 * in);
    }
}

TEST_F(P1Solve, EqualChannelsShareOneSolveAndTheReportNamesIt)
{
    const auto j = solve(slab(16), {"--extinction", "4", "--albedo", "0.99,0.99,0.9", "--sun", "0,1,0",
                                    "--sun-irradiance", "1,2,3", "--periodic", "xz"});
    EXPECT_EQ(j["counts"]["solves"], 2);
    EXPECT_EQ(j["channels"]["g"]["solved_as"], "r");
    EXPECT_NEAR(double(j["channels"]["g"]["scale"]), 2, 1e-12);
    EXPECT_EQ(j["channels"]["b"]["solved_as"], "b");
    EXPECT_GE(j["channels"]["r"]["residual_history"].size(), 3u);
    EXPECT_LT(double(j["channels"]["r"]["residual"]), 1e-6);
}

TEST_F(P1Solve, OneNumberIsTheColourOfAllChannelsOfALight)
{
    const std::string input = slab(16);
    const Words sun{"--extinction", "4", "--sun", "0,1,0", "--periodic", "xz", "--sun-irradiance"};
    Words one = sun, three = sun;
    one.push_back("2.5");
    three.push_back("2.5,2.5,2.5");
    const double a = solve(input, one)["channels"]["g"]["phi"]["largest"],
                 b = solve(input, three)["channels"]["g"]["phi"]["largest"];
    EXPECT_EQ(a, b);
    EXPECT_GT(a, 2.5);
}

TEST_F(P1Solve, ReentryOfTwoSlabsDoesNotDependOnTheGap)
{
    // Between slabs without end all that leaves an inner side would enter the other slab. In equal slabs that glow
    // alike that is half of all.
    for (int gap : {8, 24}) {
        const auto input = density("two.vdb", Vec3i(8, 16 + gap, 8), 1.0 / 8,
                                   [gap](const Vec3i& p) { return p.y() < 8 || p.y() >= 8 + gap; });
        const auto j = solve(input, {"--extinction", "2", "--albedo", "1", "--sky", "1", "--periodic", "xz"});
        EXPECT_NEAR(double(j["channels"]["r"]["budget"]["share_that_would_enter_again_and_is_lost"]), 0.5, 0.01) << gap;
        EXPECT_LT(double(j["channels"]["r"]["budget"]["defect"]), 1e-6);
    }
}

TEST_F(P1Solve, ReentryOfTwoBoxesAgreesWithTheirViewFactor)
{
    const auto lost = [&](int gap) {
        const auto input = density("boxes.vdb", Vec3i(32 + gap, 16, 16), 1.0 / 16,
                                   [gap](const Vec3i& p) { return p.x() < 16 || p.x() >= 16 + gap; });
        const auto j = solve(input, {"--extinction", "4", "--albedo", "1", "--sky", "1"});
        return double(j["channels"]["r"]["budget"]["share_that_would_enter_again_and_is_lost"]);
    };
    // Of two unit squares face to face at distance d a share F(d) of what one sends meets the other: F(1) = 0.1998,
    // F(4) = 0.0189 (Howell's catalogue C-11); each is a sixth of its cube's surface, whose other faces see nothing.
    EXPECT_NEAR(lost(16), 0.1998 / 6, 0.008);
    EXPECT_NEAR(lost(64), 0.0189 / 6, 0.002);
    const auto one = density("one.vdb", Vec3i(16, 16, 16), 1.0 / 16, [](const Vec3i&) { return true; });
    EXPECT_EQ(double(solve(one, {"--extinction", "4", "--albedo", "1", "--sky",
                                 "1"})["channels"]["r"]["budget"]["share_that_would_enter_again_and_is_lost"]),
              0);
}

TEST_F(P1Solve, SeriesInTheFileRelightsADeepSlab)
{
    const std::string input = slab(128);
    for (const char* g : {"0", "0.5"}) {
        const Words medium{"--extinction", "64", "--g", g, "--sun", "0,1,0", "--periodic", "xz", "--tolerance", "1e-8"};
        Words with = medium, direct = medium;
        with.insert(with.end(), {"--albedo", "0.9999", "--series", "8", "--galerkin", "--least-albedo", "0.98"});
        direct.insert(direct.end(), {"--albedo", "0.99"});
        solve(input, with);
        const GridFile series = read_grid_file(scratch / "out.vdb");
        solve(input, direct);
        Medium at;
        at.sigma_t_per_density = Vec3d(64);
        at.albedo = Vec3d(0.99);
        at.phase = PhaseFunction::henyey_greenstein(std::atof(g));
        const auto exact = fluence(read_collided_light(read_grid_file(scratch / "out.vdb"), at.phase, {}));
        const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(series, "density"));
        ScatterReport at_this_albedo;
        const auto relit =
            fluence(relight(series, *density, nullptr, at, {make_sun(Vec3d(0, 1, 0))}, {}, at_this_albedo));
        double error = 0, norm = 0;
        for (auto v = exact->cbeginValueOn(); v; ++v) {
            error += double((relit->tree().getValue(v.getCoord()) - *v).lengthSqr());
            norm += double(v->lengthSqr());
        }
        EXPECT_GT(norm, 0);
        EXPECT_LT(std::sqrt(error / norm), 1e-5) << g;
        EXPECT_LT(at_this_albedo.channel[0].solve.residual, 1e-3) << "the medium is periodic as the series was";
    }
}

/// The error told is that of the light scattered to the eye: here its mean over many views, one by one.
TEST_F(P1Solve, TheErrorOfASeriesIsThatOfThePicture)
{
    const auto blob = density("blob.vdb", Vec3i(16, 16, 16), 1.0 / 16,
                              [](const Vec3i& p) { return (Vec3d(p.x(), p.y(), p.z()) - Vec3d(7.5)).length() < 7; });
    const Words medium{"--extinction", "8", "--g", "0.85", "--albedo", "0.96", "--sun", "0.3,1,0.2"};
    Words with = medium;
    with.insert(with.end(), {"--series", "1"});  // a plain sum, cut early
    const auto told = solve(blob, with)["series"];
    const std::string warning = result.err;
    const GridFile series = read_grid_file(scratch / "out.vdb");
    solve(blob, medium);
    const GridFile direct = read_grid_file(scratch / "out.vdb");
    const auto numbers = [](const GridFile& file) {
        return openvdb::gridPtrCast<FloatGrid>(find_grid(file, schema::phi));
    };
    for (auto v = numbers(direct)->cbeginValueOn(); v; ++v)
        ASSERT_EQ(numbers(series)->tree().getValue(v.getCoord()), *v) << "the direct solution stays in the file";
    const CollidedLight exact_light = read_collided_light(direct, PhaseFunction(), {});

    Medium at;
    at.sigma_t_per_density = Vec3d(8);
    at.albedo = Vec3d(0.96);
    at.phase = PhaseFunction::henyey_greenstein(0.85);
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    const auto grid = openvdb::gridPtrCast<FloatGrid>(find_grid(series, "density"));
    ScatterReport at_this_albedo;
    const CollidedLight relit = relight(series, *grid, nullptr, at, {sun}, {}, at_this_albedo);
    const double m1 = 0.85 / (1 + 0.85);
    const auto phi = fluence(exact_light), of_series = fluence(relit);
    const auto towards = [&](const Vec3SGrid& fluence, const Vec3SGrid& flux, const openvdb::Coord& p, const Vec3d& s) {
        return double(fluence.tree().getValue(p)[0]) + 3 * m1 * s.dot(Vec3d(flux.tree().getValue(p)));
    };
    double error = 0, norm = 0;
    for (int k = 0; k < 64; ++k) {  // a spiral over the sphere
        const double z = 1 - (2 * k + 1) / 64.0, r = std::sqrt(1 - z * z);
        const Vec3d s(r * std::cos(2.4 * k), r * std::sin(2.4 * k), z);
        for (auto v = phi->cbeginValueOn(); v; ++v) {
            const double exact = towards(*phi, *exact_light.flux[0], v.getCoord(), s);
            error += std::pow(towards(*of_series, *relit.flux[0], v.getCoord(), s) - exact, 2);
            norm += exact * exact;
        }
    }
    EXPECT_NEAR(std::sqrt(error / norm) / double(told["error_against_direct_solve"]), 1, 0.01) << "64 views";
    EXPECT_GT(double(told["error_against_direct_solve"]), 0.01);
    EXPECT_NE(warning.find("made from the series at albedo 0.96 errs by"), std::string::npos) << warning;
}

TEST_F(P1Solve, PartialSumsOutsideTheRadiusAreStatusThree)
{
    const std::string input = slab(32);
    const Words deep{"--extinction", "64", "--albedo", "0.99", "--sun", "0,1,0", "--periodic", "xz", "--series", "4"};
    const auto j = solve(input, deep, 3);
    EXPECT_NE(result.err.find("does not converge at albedo 0.99"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("--galerkin"), std::string::npos) << result.err;
    EXPECT_GT(double(j["series"]["convergence_estimate"]), 1);
    EXPECT_EQ(test::read_text(scratch / "out.vdb"), "");

    Words shallow = deep;
    shallow[3] = "0.9999";
    const auto inside = solve(input, shallow);
    EXPECT_LT(double(inside["series"]["convergence_estimate"]), 1);
    EXPECT_LT(double(inside["series"]["error_against_direct_solve"]), 1e-3);
}

TEST_F(P1Solve, AMissedToleranceIsStatusThree)
{
    const std::string input = slab(64);
    const Words few{"--extinction", "8",  "--albedo",         "1", "--sun", "0,1,0",
                    "--periodic",   "xz", "--max-iterations", "1"};
    solve(input, few, 3);
    EXPECT_NE(result.err.find("after 1 iterations"), std::string::npos) << result.err;
    EXPECT_EQ(test::read_text(scratch / "out.vdb"), "");
    Words all_the_same = few;
    all_the_same.push_back("--allow-unconverged");
    EXPECT_EQ(solve(input, all_the_same)["channels"]["r"]["converged"], false);
    EXPECT_NE(test::read_text(scratch / "out.vdb"), "");

    // The paper's relaxation gets there, with many more.
    const auto fast = solve(input, {"--extinction", "8", "--albedo", "0.99", "--sun", "0,1,0", "--periodic", "xz"});
    const double by_multigrid = mean_phi(scratch / "out.vdb", [](const auto&) { return true; });
    const auto slow = solve(input, {"--extinction", "8", "--albedo", "0.99", "--sun", "0,1,0", "--periodic", "xz",
                                    "--solver", "relaxation", "--max-iterations", "20000"});
    EXPECT_GT(int(slow["channels"]["r"]["iterations"]), 5 * int(fast["channels"]["r"]["iterations"]));
    EXPECT_NEAR(mean_phi(scratch / "out.vdb", [](const auto&) { return true; }) / by_multigrid, 1, 1e-4);
}

TEST_F(P1Solve, ADryRunRefusesWhatTheRunRefuses)
{
    const auto whole = [](const Vec3i&) { return true; };
    const std::string odd = density("odd.vdb", Vec3i(25, 8, 8), 0.1, whole), even = slab(8);
    GridFile sheared = read_grid_file(even);
    sheared.grids[0]->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    sheared.grids[0]->transform().postShear(0.2, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
    write_grid_file(scratch / "sheared.vdb", sheared);
    const auto refused = [&](const std::string& input, const Words& options, int status, const std::string& expected) {
        for (const bool dry : {false, true}) {
            Words words{program("p1solve"), input, "-o", scratch / "out.vdb", "--sun", "0,1,0", "-q"};
            words.insert(words.end(), options.begin(), options.end());
            if (dry) words.emplace_back("--dry-run");
            const test::RunResult r = test::run(words);
            EXPECT_EQ(r.status, status) << dry << r.err;
            EXPECT_NE(r.err.find(expected), std::string::npos) << dry << r.err;
            const std::string named = status == 1 ? input + ": grid 'density'" : "";
            EXPECT_NE(r.err.find(named), std::string::npos) << dry << r.err;
        }
    };
    refused(odd, {"--periodic", "xz"}, 1, "after 25 voxels: expected a multiple of 8, such as 32");
    refused(scratch / "sheared.vdb", {}, 1, "expected axes at right angles");
    refused(even, {"--heating"}, 2, "--heating has no effect");
}

TEST_F(P1Solve, FurnaceHoldsAtAnyGrainSize)
{
    const auto input = density("balls.vdb", Vec3i(24), 1.0 / 8,
                               [](const Vec3i& p) { return (p.x() / 3 + p.y() / 5 + p.z() / 7) % 2 == 0; });
    for (const char* extinction : {"1e-9", "3", "800"}) {
        const auto j = solve(
            input, {"--extinction", extinction, "--albedo", "1", "--g", "0.85", "--sky", "0.5", "--tolerance", "1e-7"});
        EXPECT_NEAR(double(j["channels"]["r"]["phi"]["smallest"]) / (4 * M_PI * 0.5), 1, 1e-4) << extinction;
        EXPECT_NEAR(double(j["channels"]["r"]["phi"]["largest"]) / (4 * M_PI * 0.5), 1, 1e-4) << extinction;
    }
}

}  // namespace
}  // namespace vdbcloud
