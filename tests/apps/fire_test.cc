// Fire from file to picture: what a temperature shines, that it lights its smoke, and that all stages take it alike.
#include "stages.h"
#include "support/picture_file.h"

#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/blackbody.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

/// A grid in the voxels of a sphere of `radius` voxels about the origin.
FloatGridPtr sphere(const char* name, int radius, const std::function<double(Coord)>& f)
{
    const auto grid = FloatGrid::create(0.0f);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (int i = -radius; i <= radius; ++i)
        for (int j = -radius; j <= radius; ++j)
            for (int k = -radius; k <= radius; ++k)
                if (i * i + j * j + k * k <= radius * radius)
                    grid->tree().setValue(Coord(i, j, k), float(f(Coord(i, j, k))));
    return grid;
}

/// One temperature in the density's voxels and one voxel about, where the trilinear density ends.
FloatGridPtr isothermal(double kelvin, int radius = 8)
{
    return sphere("temperature", radius + 2, [=](Coord) { return kelvin; });
}

class Fires : public Stages {
protected:
    std::string file(const std::string& name, std::vector<GridBasePtr> grids)
    {
        write_grid_file(scratch / name, file_of(std::move(grids)));
        return scratch / name;
    }
    std::string ball_at(double kelvin, const std::string& name = "fire.vdb")
    {
        return file(name, {sphere("density", 8, [](Coord) { return 1.0; }), isothermal(kelvin)});
    }
    /// The colour of the pixel in the middle, and its transmittance.
    struct Middle {
        Vec3d colour;
        double transmittance;
    };
    Middle middle(const std::string& input, Words options)
    {
        options = with(options, {"--projection", "orthographic", "--camera", "0,0,40", "--look-at", "0,0,0",
                                 "--ortho-width", "0.01", "--resolution", "1", "--aov", "transmittance", "-q"});
        const PictureFile p = picture_file(stage("render", input, "p.exr", options));
        return {Vec3d(p.at(0, 0, "R"), p.at(0, 0, "G"), p.at(0, 0, "B")), p.at(0, 0, "transmittance.R")};
    }
    static PictureFile picture_file(const std::string& path) { return test::picture(path); }
    RunResult refused(Words words, int status)
    {
        words.front() = program(words.front());
        RunResult r = run(words);
        EXPECT_EQ(r.status, status) << r.err;
        return r;
    }
};

void expect_close(const Vec3d& found, const Vec3d& expected, double relative)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], relative * std::abs(expected[c]) + 1e-12) << c;
}

TEST_F(Fires, IsothermalBodyShowsPlancksRadianceTimesOneLessTransmittance)
{
    // 17 voxels of 1 and two ramps of half a one: tau = 17.000 x extinction, of floats and the march's tolerance.
    const std::string fire = ball_at(1500);
    for (const double extinction : {0.01, 0.2, 5.0}) {
        const Middle seen =
            middle(fire, {"--extinction", std::to_string(extinction), "--albedo", "0", "--background", "none"});
        EXPECT_NEAR(seen.transmittance, std::exp(-17 * extinction), 1e-4);
        expect_close(seen.colour, (1 - std::exp(-17 * extinction)) * blackbody(1500), 1e-3);
    }
    // By light paths too, within the noise of 4000 of them; emission is integrated along the ray, without noise.
    expect_close(middle(fire, {"--extinction", "0.2", "--albedo", "0", "--background", "none", "--integrator", "path",
                               "--spp", "16"})
                     .colour,
                 (1 - std::exp(-3.4)) * blackbody(1500), 2e-3);
}

TEST_F(Fires, MediumAtTheTemperatureOfItsWallCannotBeSeen)
{
    const std::string fire = ball_at(2400);
    const Vec3d wall = blackbody(2400);
    const std::string sky = std::to_string(wall[0]) + "," + std::to_string(wall[1]) + "," + std::to_string(wall[2]);
    for (const char* albedo : {"0.3", "0.8"}) {
        const Words medium{"--extinction", "0.15", "--albedo", albedo, "--sky", sky, "-q"};
        // P1 with a sky as inflow is exact in a furnace, to its tolerance and the windows of a round body.
        const std::string solved = stage("p1solve", fire, "solved.vdb", medium);
        expect_close(middle(solved, {"--background", sky}).colour, wall, 5e-3);
        expect_close(middle(solved, {"--background", sky, "--gather", "2", "--spp", "64"}).colour, wall, 1e-2);
    }
}

TEST_F(Fires, SootIsTheAlbedoOfWhatBurnsAndIsKept)
{
    const std::string fire = ball_at(1500), lit = stage("illuminate", fire, "lit.vdb", {"--sun", "0,1,0"});
    EXPECT_EQ(read_medium(*read_grid_file(lit).grids[0]).albedo, Vec3d(0.25));
    const std::string cold = stage("illuminate", ball_at(290, "air.vdb"), "cold.vdb", {"--sun", "0,1,0"});
    EXPECT_EQ(read_medium(*read_grid_file(cold).grids[0]).albedo, Vec3d(1.0));
    const std::string asked = stage("illuminate", fire, "asked.vdb", {"--sun", "0,1,0", "--albedo", "0.7"});
    EXPECT_EQ(read_medium(*read_grid_file(asked).grids[0]).albedo, Vec3d(0.7));
    expect_close(middle(asked, {"--extinction", "5", "--sun-irradiance", "0", "--sun", "0,1,0"}).colour,
                 0.3 * blackbody(1500), 1e-3);
}

TEST_F(Fires, LightTheirOwnSmoke)
{
    // A small fire in the middle of cold smoke.
    const auto heat = sphere("temperature", 2, [](Coord) { return 1900.0; });
    const std::string fire = file("fire.vdb", {sphere("density", 8, [](Coord) { return 1.0; }), heat});
    const std::string solved =
        stage("p1solve", fire, "solved.vdb", {"--extinction", "0.1", "--albedo", "0.9", "--iterations", "3"});
    const Words side{"--projection",  "orthographic", "--camera",     "5,0,40", "--look-at", "5,0,0",
                     "--ortho-width", "0.01",         "--resolution", "1",      "-q"};
    const PictureFile ours = picture_file(stage("render", solved, "ours.exr", side));
    const PictureFile truth =
        picture_file(stage("render", solved, "truth.exr", with(side, {"--integrator", "path", "--spp", "20000"})));
    // The noise of the paths is 1 %; rays of compact emission err by 3 % in voxels of a tenth of a mean free path.
    EXPECT_GT(ours.at(0, 0, "R"), 0);
    EXPECT_NEAR(ours.at(0, 0, "R"), truth.at(0, 0, "R"), 0.06 * double(truth.at(0, 0, "R")));
    EXPECT_NEAR(ours.at(0, 0, "G"), truth.at(0, 0, "G"), 0.06 * double(truth.at(0, 0, "G")));
}

TEST_F(Fires, LightTheGroundWithFewRays)
{
    // A ball of fire of radius 2 at a height of 30 over a white floor, thin: a point of power 4 pi int j dV. The floor
    // below has the radiance int j dV / (pi h^2), by the inverse square 30 at its middle, which the ball's size changes
    // by (2 / 30)^2.
    const auto fire = sphere("density", 2, [](Coord) { return 1.0; });
    const std::string name = file("point.vdb", {fire, isothermal(1900, 2)});
    const PictureFile p = picture_file(stage("render", name, "floor.exr",
                                             {"--extinction",
                                              "1e-4",
                                              "--albedo",
                                              "0",
                                              "--solid",
                                              "plane;at=0,-30,0;colour=1",
                                              "--solid-rays",
                                              "12",
                                              "--effects",
                                              "emission,solids",
                                              "--projection",
                                              "orthographic",
                                              "--camera",
                                              "20,20,0",
                                              "--look-at",
                                              "0,-30,0",
                                              "--ortho-width",
                                              "0.01",
                                              "--resolution",
                                              "4",
                                              "-q"}));
    // The trilinear ball has the sum of its voxels.
    const double expected = 1e-4 * double(fire->activeVoxelCount()) / (3.14159265358979 * 900);
    double sum = 0, square = 0;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double share = double(p.at(i, j, "R")) / (expected * blackbody(1900)[0]);
            sum += share / 16, square += share * share / 16;
        }
    EXPECT_NEAR(sum, 1, 0.03);
    EXPECT_LT(std::sqrt(std::max(square - sum * sum, 0.0)), 0.2) << "a pixel by reflected rays alone has 3";
}

TEST_F(Fires, ScaleOfNormalisedValuesIsGuessedOnceAndTravels)
{
    const auto normalised = [](double top) { return sphere("heat", 10, [top](Coord) { return top; }); };
    const auto density = [] { return sphere("density", 8, [](Coord) { return 1.0; }); };
    const std::string fire = file("f1.vdb", {density(), normalised(0.5)});
    file("f2.vdb", {density(), normalised(0.4)});
    const RunResult guess =
        run({program("illuminate"), fire, "--sun", "0,1,0", "--extinction", "5", "-o", scratch / "g.vdb"});
    EXPECT_EQ(guess.status, 0) << guess.err;
    EXPECT_NE(guess.err.find("grid 'heat' has no unit, and its greatest value is 0.5: taken as 2000 K; "
                             "--temperature-scale 4000"),
              std::string::npos)
        << guess.err;
    expect_close(middle(scratch / "g.vdb", {"--albedo", "0", "--effects", "emission"}).colour, blackbody(2000), 1e-3);
    // What was said once is not guessed again, and all frames of a run share one guess.
    const RunResult again = run({program("p1solve"), scratch / "g.vdb", "-o", scratch / "h.vdb"});
    EXPECT_EQ(again.err.find("has no unit"), std::string::npos) << again.err;
    RunOptions there;
    there.folder = scratch.path();
    const RunResult frames = shell("illuminate f%d.vdb --frames 1,2 --sun 0,1,0 -o o%d.vdb", there);
    EXPECT_EQ(frames.status, 0) << frames.err;
    EXPECT_EQ(get_number(*read_grid_file(scratch / "o2.vdb").grids[1], schema::kelvin_scale, 0), 4000);
    // Given, it is taken; and a unit is believed.
    expect_close(middle(fire, {"--temperature-scale", "2000", "--temperature-offset", "500", "--extinction", "5",
                               "--albedo", "0", "--effects", "emission"})
                     .colour,
                 blackbody(1500), 1e-3);
    const auto kelvin = normalised(90);
    set_text(*kelvin, schema::unit, "K");
    const RunResult cold =
        run({program("illuminate"), file("k.vdb", {density(), kelvin}), "--sun", "0,1,0", "-o", scratch / "k2.vdb"});
    EXPECT_EQ(cold.err.find("albedo"), std::string::npos) << cold.err;
}

TEST_F(Fires, FlameShinesWithoutSmoke)
{
    const auto thin = sphere("density", 8, [](Coord) { return 1e-6; });
    const auto flame = sphere("flame", 8, [](Coord) { return 0.5; });
    const std::string fire = file("fire.vdb", {thin, isothermal(1700), flame});
    const Words look{"--extinction", "1", "--albedo", "0", "--effects", "emission"};
    // 17 voxels of flame 0.5, whose absorption is the extinction.
    expect_close(middle(fire, look).colour, 17 * 0.5 * blackbody(1700), 1e-3);
    expect_close(middle(fire, with(look, {"--flame-absorption", "0.1"})).colour, 17 * 0.05 * blackbody(1700), 1e-3);
    set_text(*flame, schema::unit, "kg m-3 s-1");
    const std::string rate = file("rate.vdb", {thin, isothermal(1700), flame});
    expect_close(middle(rate, look).colour, 17e-6 * blackbody(1700), 1e-3);
    refused({"render", ball_at(1500), "--flame-absorption", "1", "-o", scratch / "n.exr"}, 2);
}

TEST_F(Fires, WhatWasSaidOfThemTravels)
{
    const auto thin = sphere("density", 8, [](Coord) { return 1e-6; });
    const auto flame = sphere("flame", 8, [](Coord) { return 0.5; });
    const std::string lit = stage("illuminate", file("fire.vdb", {thin, isothermal(1200), flame}), "lit.vdb",
                                  {"--sun", "0,1,0", "--extinction", "1", "--albedo", "0", "--temperature-offset",
                                   "500", "--fire-intensity", "0.5", "--flame-absorption", "0.1", "-q"});
    expect_close(middle(lit, {"--effects", "emission"}).colour, 0.5 * 17 * 0.05 * blackbody(1700), 1e-3);
}

TEST_F(Fires, AreOfOneKindInAllStages)
{
    const std::string fire = ball_at(1500);
    const std::string solved = stage("p1solve", fire, "solved.vdb", {"--extinction", "0.2"});
    EXPECT_EQ(run({program("render"), solved, "--resolution", "4", "-o", scratch / "p.exr"}).status, 0);
    const RunResult hotter =
        refused({"render", solved, "--resolution", "4", "--temperature-offset", "300", "-o", scratch / "p.exr"}, 2);
    EXPECT_NE(hotter.err.find("another emission than the file holds now: run p1solve again"), std::string::npos)
        << hotter.err;
    // Two files in one solve: the emission of both, once.
    const auto moved = isothermal(1500);
    const std::string both =
        stage("illuminate", fire + "", "both.vdb",
              {ball_at(1900, "second.vdb"), "--extinction", "5", "--albedo", "0", "--sun", "0,1,0"});
    const Words all = names(both);
    EXPECT_EQ(std::count(all.begin(), all.end(), "emission"), 1);
    EXPECT_EQ(std::count(all.begin(), all.end(), "temperature"), 0);
    expect_close(middle(both, {"--effects", "emission"}).colour, 0.5 * (blackbody(1500) + blackbody(1900)), 1e-3);
    expect_close(
        middle(fire, {scratch / "second.vdb", "--extinction", "5", "--albedo", "0", "--effects", "emission"}).colour,
        0.5 * (blackbody(1500) + blackbody(1900)), 1e-3);
}

TEST_F(Fires, AirOfACloudCostsNothing)
{
    const auto effects = [&](const std::string& tool, const std::string& input) {
        RunOptions there;
        there.folder = scratch.path();
        const std::string out = tool == "render" ? " --resolution 6 -o out.exr" : " -o out.vdb";
        const RunResult r =
            shell(tool + " " + input + " --extinction 0.3 --albedo 0.9 --sun 0,1,0 --json r.json" + out, there);
        EXPECT_EQ(r.status, 0) << r.err;
        auto report = nlohmann::json::parse(read_text(scratch / "r.json"));
        auto found = report["effects"];
        for (auto& effect : found) effect.erase("cpu_seconds");
        return found.dump() + report["counts"].dump();
    };
    file("without.vdb", {sphere("density", 8, [](Coord) { return 1.0; })});
    ball_at(290, "air.vdb");
    ball_at(1500, "fire.vdb");
    for (const char* tool : {"p1solve", "render"})
        EXPECT_EQ(effects(tool, "air.vdb"), effects(tool, "without.vdb")) << tool;
    EXPECT_NE(effects("render", "fire.vdb"), effects("render", "without.vdb"));
}

TEST_F(Fires, OddTemperaturesEndWellOrAreRefused)
{
    for (const double t : {0.0, -500.0, 1e9}) {
        const std::string fire = ball_at(t);
        const Middle seen = middle(fire, {"--extinction", "5", "--albedo", "0", "--effects", "emission"});
        expect_close(seen.colour, t > 0 ? blackbody(t) : Vec3d(0.0), 1e-3);
    }
    const auto broken = isothermal(1500);
    broken->tree().setValue(Coord(1, 2, 3), std::nanf(""));
    const std::string nan = file("nan.vdb", {sphere("density", 8, [](Coord) { return 1.0; }), broken});
    const RunResult r = refused({"render", nan, "-o", scratch / "n.exr"}, 1);
    EXPECT_NE(r.err.find("grid 'temperature': value nan at voxel [1, 2, 3]: expected finite"), std::string::npos)
        << r.err;
    const RunResult none = refused({"p1solve", file("d.vdb", {sphere("density", 8, [](Coord) { return 1.0; })}),
                                    "--temperature-scale", "3", "-o", scratch / "n.vdb"},
                                   2);
    EXPECT_NE(none.err.find("--temperature-scale"), std::string::npos) << none.err;
    // What is too cold to glow is told.
    const RunResult faint = run({program("p1solve"), ball_at(400), "--fire-intensity", "3", "--extinction", "0.2", "-o",
                                 scratch / "faint.vdb"});
    EXPECT_EQ(faint.status, 0) << faint.err;
    EXPECT_NE(faint.err.find("--fire-intensity changes nothing: the hottest place has 400 K"), std::string::npos)
        << faint.err;
    // Of two inputs one is enough.
    const std::string fire = ball_at(1500), cold = scratch / "d.vdb";
    EXPECT_EQ(run({program("p1solve"), cold, fire, "--temperature-scale", "1.1", "--extinction", "0.2", "-o",
                   scratch / "two.vdb"})
                  .status,
              0);
    EXPECT_EQ(run({program("render"), fire, cold, "--temperature-scale", "1.1", "--extinction", "0.2", "--resolution",
                   "4", "-o", scratch / "two.exr"})
                  .status,
              0);
}

}  // namespace
}  // namespace vdbcloud::test
