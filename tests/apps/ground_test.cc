// --ground-albedo: from p1solve through the file to the picture, against light paths; contradictions are told.
#include "apps/repeating_field.h"
#include "support/picture_file.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/collided_light.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

class Grounds : public RepeatingField {
protected:
    std::string field() { return RepeatingField::field("field.vdb", 0.125); }
};

const Words of_field{"--extinction", "4", "--albedo", "0.98", "--sun", "0.6,1,0.3", "--periodic", "xz"};

TEST_F(Grounds, ASweptFieldOverItIsThatOfPaths)
{
    const std::string input = field();
    const std::string solved =
        stage("p1solve", input, "solved.vdb",
              with(of_field, {"--ground-albedo", "0.7", "--iterations", "12", "--directions", "128"}));
    EXPECT_EQ(read_ground(*fluence_grid(read_grid_file(solved))), 0.7);
    // One pixel over a period, from straight above and aslant: means, which voxels of half a mean free path and 128
    // directions give to 2 %. Without the ground they are a third darker.
    for (const char* camera : {"0.9375,9,0.9375", "7.9375,9,0.9375"}) {
        const Words one{"--projection",  "orthographic",
                        "--camera",      camera,
                        "--look-at",     "0.9375,0,0.9375",
                        "--ortho-width", "2",
                        "--resolution",  "4",
                        "--aov",         "all"};
        const auto seen = test::picture(stage("render", solved, "cells.exr", with(one, {"--samples", "16"})));
        const auto truth =
            test::picture(stage("render", solved, "path.exr", with(one, {"--integrator", "path", "--samples", "500"})));
        double mean[2][2] = {{0, 0}, {0, 0}}, squares = 0;
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x) {
                for (int k = 0; k < 2; ++k) {
                    mean[0][k] += seen.at(x, y, k ? "ground.R" : "R") / 16;
                    mean[1][k] += truth.at(x, y, k ? "ground.R" : "R") / 16;
                }
                squares += std::pow(truth.at(x, y, "standard_error.R") / 16, 2);
                EXPECT_EQ(seen.at(x, y, "A"), 1);
                EXPECT_EQ(truth.at(x, y, "A"), 1);
                EXPECT_NEAR(seen.at(x, y, "background.R"), 0, 0);
            }
        const double error = std::sqrt(squares);
        EXPECT_LT(error, 0.01 * mean[1][0]);
        EXPECT_NEAR(mean[0][0], mean[1][0], 3 * error + 0.02 * mean[1][0]) << camera;
        EXPECT_NEAR(mean[0][1], mean[1][1], 3 * error + 0.02 * mean[1][1]) << camera;
        EXPECT_GT(mean[1][1], 0.2 * mean[1][0]) << "the ground is seen";
    }
}

TEST_F(Grounds, AnIsolatedCloudOverItIsThatOfPaths)
{
    // Three views: of the cloud and its shadow from above and aslant, and of the cloud alone from the side. 32
    // directions, degree 1 and voxels of a third of a mean free path: views within 4 %, the ground within 2 %. Without
    // a ground the side is a third darker.
    const auto grid = box(Vec3i(12, 12, 12), 1.0 / 12, [](Coord c) {
        const Vec3d x = (Vec3d(c[0], c[1], c[2]) + Vec3d(0.5)) / 6.0 - Vec3d(1.0);
        return std::max(0.0, 1 - x.dot(x) - 0.5 * x[0] * x[1]);
    });
    const std::string input = scratch / "cloud.vdb";
    write_grid_file(input, file_of({grid}));
    const Words lit{"--extinction", "6", "--albedo", "0.99", "--sun", "0.6,1,0.3"};
    const std::string solved =
        stage("p1solve", input, "solved.vdb", with(lit, {"--ground-albedo", "0.7", "--iterations", "6"}));
    EXPECT_EQ(read_ground(*fluence_grid(read_grid_file(solved))), 0.7);
    const std::string alone = stage("p1solve", input, "alone.vdb", with(lit, {"--iterations", "6"}));
    for (const auto& [camera, width] :
         {std::pair("0.5,9,0.5", "1.6"), std::pair("7,6,8", "1.6"), std::pair("0.5,0.5,-9", "1")}) {
        const Words one{"--projection",  "orthographic", "--camera",     camera, "--look-at", "0.5,0.5,0.5",
                        "--ortho-width", width,          "--resolution", "6",    "--aov",     "all"};
        const auto seen = test::picture(stage("render", solved, "cells.exr", with(one, {"--samples", "16"})));
        const auto dark = test::picture(stage("render", alone, "alone.exr", with(one, {"--samples", "16"})));
        const auto truth =
            test::picture(stage("render", solved, "path.exr", with(one, {"--integrator", "path", "--samples", "200"})));
        double mean[3] = {0, 0, 0}, ground[2] = {0, 0}, squares = 0;
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 6; ++x) {
                mean[0] += seen.at(x, y, "R") / 36;
                mean[1] += truth.at(x, y, "R") / 36;
                mean[2] += dark.at(x, y, "R") / 36;
                ground[0] += seen.at(x, y, "ground.R") / 36;
                ground[1] += truth.at(x, y, "ground.R") / 36;
                squares += std::pow(truth.at(x, y, "standard_error.R") / 36, 2);
            }
        const double error = std::sqrt(squares);
        EXPECT_LT(error, 0.02 * mean[1]);
        EXPECT_NEAR(mean[0], mean[1], 3 * error + 0.04 * mean[1]) << camera;
        EXPECT_NEAR(ground[0], ground[1], 3 * error + 0.02 * mean[1]) << camera;
        EXPECT_LT(mean[2], 0.75 * mean[1]) << camera;
    }
}

TEST_F(Grounds, TheReportClosesAndTheFileIsDrawnAsItWasSolved)
{
    const std::string input = field(), report = scratch / "report.json";
    const std::string solved = stage("p1solve", input, "solved.vdb",
                                     with(of_field, {"--ground-albedo", "0.7", "--iterations", "8", "--json", report}));
    const auto budget = nlohmann::json::parse(read_text(report))["channels"]["r"]["budget"];
    const double in = double(budget["beam_lost_in_medium"]) + double(budget["direct_on_ground"]);
    const double out = double(budget["out_of_top"]) + double(budget["absorbed"]) + double(budget["absorbed_by_ground"]);
    EXPECT_NEAR(out / in, 1, 1e-4);
    EXPECT_NEAR(double(budget["from_ground"]) /
                    (0.7 * (double(budget["direct_on_ground"]) + double(budget["out_of_base"]))),
                1, 1e-5);
    const Words all = names(solved);
    EXPECT_EQ(std::count(all.begin(), all.end(), "ground_radiance"), 1);
    // A second solve without a ground removes it.
    const std::string again = stage("p1solve", solved, "again.vdb", {});
    const Words left = names(again);
    EXPECT_EQ(std::count(left.begin(), left.end(), "ground_radiance"), 0);
    EXPECT_FALSE(read_ground(*fluence_grid(read_grid_file(again))));
    // Paths take the file's ground, and another one when asked.
    const Words view{"--integrator", "path", "--samples", "2", "--direction", "0.3,-1,0.2"};
    const auto from_file = picture(solved, view);
    EXPECT_EQ(picture(solved, with(view, {"--ground-albedo", "0.7"})), from_file);
    EXPECT_NE(picture(solved, with(view, {"--ground-albedo", "0.2"})), from_file);
    // Without p1solve a ground is for paths alone, under any medium.
    ended("render",
          {input, "--extinction", "4", "--integrator", "path", "--ground-albedo", "0.5", "--resolution", "4", "-o",
           scratch / "alone.exr"},
          0);
}

TEST_F(Grounds, ContradictionsAreTold)
{
    const std::string input = field(), out = scratch / "out.vdb", image = scratch / "out.exr";
    says(ended("p1solve", {input, "--ground-albedo", "0.5", "--lamp", "1,5,1", "-o", out}, 1), "expected a sun");
    says(ended("p1solve", {input, "--ground-albedo", "0.5", "--periodic", "x", "-o", out}, 2), "--periodic x");
    says(ended("p1solve", {input, "--ground-albedo", "0.5", "--periodic", "xz", "--up", "z", "-o", out}, 1),
         "ends along up");
    says(ended("p1solve", {input, "--ground-albedo", "0.5", "--periodic", "xz", "--sun", "0,-1,0", "-o", out}, 1),
         "not above the ground");
    says(ended("p1solve", {input, "--ground-albedo", "1.5", "--periodic", "xz", "-o", out}, 2), "--ground-albedo");
    for (const Words& other : {Words{"--limiter", "levermore-pomraning"}, Words{"--series", "2"}})
        says(ended("p1solve", with({input, "--ground-albedo", "0.5", "--periodic", "xz", "-o", out}, other), 2),
             "--ground-albedo with " + other[0]);
    says(ended("render", {input, "--ground-albedo", "0.5", "-o", image}, 2), "--integrator path");
    const std::string solved = stage("p1solve", input, "solved.vdb", with(of_field, {"--ground-albedo", "0.5"}));
    says(ended("render", {solved, "--up", "z", "-o", image}, 2), "run p1solve again with --up");
    const std::string gaps = scratch / "gaps.vdb";
    write_grid_file(gaps, file_of({box(Vec3i(8, 8, 8), 0.1, [](Coord c) { return c[0] < 5 ? 1.0 : 0.0; })}));
    says(ended("p1solve", with({gaps, "--ground-albedo", "0.5", "-o", out}, of_field), 1), "--iterations 5");
}

}  // namespace
}  // namespace vdbcloud::test
