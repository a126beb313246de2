// Media that repeat: --periodic travels in the file from illuminate and p1solve to render, and contradictions are told.
#include "apps/repeating_field.h"
#include "support/picture_file.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/collided_light.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;
using Axes = std::array<bool, 3>;

class Periodic : public RepeatingField {
protected:
    std::string field(const std::string& name, const Vec3i& size = Vec3i(16, 8, 16))
    {
        return RepeatingField::field(name, 0.1, size);
    }
    static Axes axes(const std::string& path, const std::string& grid)
    {
        return read_periodic(*find_grid(read_grid_file(path), grid));
    }
};

const Axes xz{true, false, true}, x_alone{true, false, false}, none{};

TEST_F(Periodic, AxesTravelFromIlluminateToThePicture)
{
    const std::string input = field("field.vdb");
    const std::string lit = stage("illuminate", input, "lit.vdb", with(medium, {"--periodic", "xz"}));
    EXPECT_EQ(axes(lit, "transmittance_sun"), xz);
    const std::string solved = stage("p1solve", lit, "solved.vdb", {});
    EXPECT_EQ(axes(solved, "phi"), xz);
    EXPECT_EQ(axes(solved, "transmittance_sun"), xz);
    const auto found = picture(solved, {}), asked = picture(solved, {"--periodic", "xz"});
    EXPECT_EQ(found, asked);
    // Without results the option alone makes the medium repeat, for paths too.
    const Words by_path{"--integrator", "path", "--samples", "8"};
    const auto once = picture(input, with(medium, by_path));
    EXPECT_EQ(picture(input, with(medium, with(by_path, {"--periodic", "none"}))), once);
    const auto repeated = picture(input, with(medium, with(by_path, {"--periodic", "xz"})));
    EXPECT_NE(repeated, once);
    EXPECT_EQ(picture(solved, by_path), repeated) << "paths take the axes of the results";
    EXPECT_NE(picture(lit, {}), picture(lit, {"--periodic", "none"}));
}

TEST_F(Periodic, P1solveComputesTheLightOfThePeriodicMedium)
{
    const std::string input = field("field.vdb");
    const std::string lit = stage("illuminate", input, "lit.vdb", medium);
    EXPECT_EQ(axes(lit, "transmittance_sun"), none);
    const std::string solved = stage("p1solve", lit, "solved.vdb", {"--periodic", "xz"});
    EXPECT_EQ(axes(solved, "transmittance_sun"), xz);
    EXPECT_EQ(axes(solved, "phi"), xz);
    // phi goes on behind the seam: the fringe holds the values of the other side.
    const auto phi = openvdb::gridPtrCast<FloatGrid>(fluence_grid(read_grid_file(solved)));
    ASSERT_TRUE(phi);
    for (const Coord& c : {Coord(-1, 3, 5), Coord(16, 0, 7), Coord(4, 0, 16), Coord(-1, -1, -1), Coord(16, 8, 2)}) {
        const Coord home((c[0] + 16) % 16, c[1], (c[2] + 16) % 16);
        EXPECT_EQ(phi->tree().isValueOn(c), phi->tree().isValueOn(home)) << c;
        EXPECT_EQ(phi->tree().getValue(c), phi->tree().getValue(home)) << c;
    }
    const std::string again = stage("p1solve", solved, "again.vdb", {"--periodic", "x"});
    EXPECT_EQ(axes(again, "phi"), x_alone);
    EXPECT_EQ(axes(again, "transmittance_sun"), x_alone);
}

TEST_F(Periodic, LinesCoverTheEmptyColumnsOfAPeriod)
{
    // A bar whose period is half empty, lit aslant: lines through one period meet it from both sides of the seam. A
    // line a voxel errs by 2 %; lines through the bar's own columns alone meet half of it.
    const auto bar = box({16, 8, 8}, 0.125, [](Coord c) { return c[0] < 8 ? 1.0 : 0.0; });
    write_grid_file(scratch / "bar.vdb", file_of({bar}));
    const std::string report = scratch / "report.json";
    stage("p1solve", scratch / "bar.vdb", "out.vdb",
          {"--extinction", "0.2", "--albedo", "0.9", "--sun", "1,1,0", "--periodic", "xz", "--json", report});
    const auto json = nlohmann::json::parse(read_text(report));
    EXPECT_NEAR(double(json["channels"]["r"]["budget"]["faces_against_lines"]), 0, 0.05);
    EXPECT_GT(double(json["channels"]["r"]["budget"]["beam_lost_by_lines"]), 0.1);
}

TEST_F(Periodic, ContradictionsAreTold)
{
    const std::string input = field("field.vdb");
    const std::string lit = stage("illuminate", input, "lit.vdb", with(medium, {"--periodic", "xz"}));
    const std::string solved = stage("p1solve", lit, "solved.vdb", {});
    const std::string plain = stage("illuminate", input, "plain.vdb", medium);
    const std::string out = scratch / "out.exr";
    says(ended("render", {solved, "--periodic", "x", "-o", out}, 2),
         "periodic along xz, and --periodic x is asked for");
    says(ended("render", {solved, "--periodic", "none", "-o", out}, 2), "run p1solve again");
    says(ended("render", {lit, "--periodic", "x", "--resolution", "4", "-o", out}, 0),
         "belongs to a medium periodic along xz, now x; the grid is computed again");
    says(ended("render", {lit, plain, "--resolution", "4", "-o", out}, 2), "choose with --periodic");
    says(ended("p1solve", {lit, plain, "-o", scratch / "both.vdb"}, 2), "choose with --periodic");
    for (const char* wrong : {"xyz", "xx", "w", "X"})
        for (const char* name : {"illuminate", "p1solve", "render"})
            says(ended(name,
                       {input, "--periodic", wrong, "-o", name == std::string("render") ? out : scratch / "out.vdb"},
                       2),
                 "expected none, or one or two");
    for (const char* name : {"illuminate", "p1solve"}) {
        says(ended(name, {input, "--periodic", "xz", "--lamp", "1,2,3", "-o", scratch / "out.vdb"}, 1),
             "expected a light at infinity");
        says(ended(name, {input, "--periodic", "xz", "--sun", "1,0,3", "-o", scratch / "out.vdb"}, 1),
             "not parallel to every axis that ends");
    }
    says(ended("illuminate", {input, "--periodic", "xz", "--rays-per-voxel", "2", "-o", scratch / "out.vdb"}, 2),
         "--periodic none");
    says(ended("render", {input, "--periodic", "xz", "--fidelity", "exact", "-o", out}, 2), "--periodic none");
    says(ended("render", {input, field("narrow.vdb", Vec3i(8, 8, 16)), "--periodic", "xz", "-o", out}, 1),
         "expected equal periods");
}

TEST_F(Periodic, AThinSlabBySweepsIsThatOfPaths)
{
    const auto slab = box({8, 16, 8}, 1.0 / 16, [](Coord) { return 1.0; });
    write_grid_file(scratch / "slab.vdb", file_of({slab}));
    const Words of_slab{"--extinction", "1.5", "--albedo", "0.95", "--g", "0.5", "--sun", "1,1,0"};
    const std::string solved =
        stage("p1solve", scratch / "slab.vdb", "solved.vdb",
              with(of_slab, {"--periodic", "xz", "--iterations", "8", "--directions", "128", "--degree", "5"}));
    for (const char* camera : {"0.2,9,0.3", "-3.8,4.5,2.3", "2.2,-9,0.3"}) {
        const Words view{"--projection",  "orthographic", "--camera",     camera, "--look-at", "0.2,0.5,0.3",
                         "--ortho-width", "0.01",         "--resolution", "1",    "--aov",     "all"};
        const auto seen = test::picture(stage("render", solved, "cells.exr", view));
        const auto truth = test::picture(
            stage("render", solved, "path.exr", with(view, {"--integrator", "path", "--samples", "40000"})));
        const double error = truth.at(0, 0, "standard_error.R");
        EXPECT_GT(truth.at(0, 0, "R"), 0.02);
        EXPECT_LT(error, 0.01 * truth.at(0, 0, "R"));
        // Sweeps of degree 5 err by 2 % of a slab's radiance at most (docs/benchmarks.md).
        EXPECT_NEAR(seen.at(0, 0, "R"), truth.at(0, 0, "R"), 3 * error + 0.02 * truth.at(0, 0, "R")) << camera;
        EXPECT_NEAR(seen.at(0, 0, "transmittance.R"), truth.at(0, 0, "transmittance.R"), 1e-3);
    }
}

}  // namespace
}  // namespace vdbcloud::test
