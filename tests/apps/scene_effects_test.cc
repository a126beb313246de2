// Effects on demand: an effect that is off costs nothing, what is left out is said, and forced effects change nothing.
#include "stages.h"

#include "vdbcloud/core/effects.h"
#include "vdbcloud/optics/medium.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace vdbcloud::test {
namespace {

/// A grid of one value in the voxels of write_ball()'s density.
GridBasePtr filled(const char* name, const Vec3f& value)
{
    const auto shape = ball("density", 5);
    const auto grid = Vec3SGrid::create();
    for (auto v = shape->cbeginValueOn(); v; ++v) grid->tree().setValue(v.getCoord(), value);
    grid->setTransform(shape->transform().copy());
    grid->setName(name);
    return grid;
}

class SceneEffects : public Stages {
protected:
    SceneEffects()
    {
        write("ball.vdb", {});
        const FloatGridPtr slab = FloatGrid::create(0.0f);
        slab->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(7)), 1.0f);
        slab->setName("density");
        write_grid_file(scratch / "slab.vdb", file_of({slab}));
        write("glow.vdb", {filled("emission", Vec3f(0.3f, 0.2f, 0.1f))});
        write("dark.vdb", {filled("emission", Vec3f(0.0f))});
        write("red.vdb", {filled("Cd", Vec3f(1, 0.5f, 0.5f))});
        write("white.vdb", {filled("Cd", Vec3f(1.0f))});
    }
    void write(const std::string& name, const std::vector<GridBasePtr>& others)
    {
        write_ball(name, "density", openvdb::GRID_FOG_VOLUME, others);
    }

    /// The report of a command, whose words are separated by blanks.
    nlohmann::json report(const std::string& tool, const std::string& line)
    {
        nlohmann::json& report = reports_[tool + line];
        if (report.is_null()) report = new_report(tool, line);
        return report;
    }
    nlohmann::json new_report(const std::string& tool, const std::string& line)
    {
        RunOptions there;
        there.folder = scratch.path();
        const RunResult r =
            shell(tool + " --threads 1 --json report.json " + line + (tool == "render" ? " -o out.exr" : " -o out.vdb"),
                  there);
        EXPECT_EQ(r.status, 0) << tool << " " << line << "\n" << r.err;
        auto report = nlohmann::json::parse(read_text(scratch / "report.json"));
        report["said"] = r.err;
        return report;
    }
    /// Of three runs: which pages of libraries are resident differs from run to run by some tenths of a per cent.
    double least_memory(const std::string& tool, const std::string& line)
    {
        double least = report(tool, line)["peak_memory_bytes"];
        for (int run = 0; run < 2; ++run) least = std::min(least, double(new_report(tool, line)["peak_memory_bytes"]));
        return least;
    }

private:
    std::map<std::string, nlohmann::json> reports_;
};

/// Commands of one program without an effect, with it there and adding nothing (may be empty), and with it.
struct Row {
    Effect effect;
    std::string tool, without, idle, on;
};

const std::vector<Row>& rows()
{
    const std::string light = "ball.vdb --extinction 0.5 --albedo 0.9 --g 0 --sun 0,1,0 ",
                      picture = light + "--resolution 6 ";
    const auto in = [](const char* file, const std::string& command) { return file + command.substr(8); };
    const std::string solid = "--solid 'sphere;at=0,9,0;radius=2' ", paths = "--integrator path --spp 1 ";
    static const std::vector<Row> all = {
        {Effect::Lights, "illuminate", "", light + "--sun-irradiance 0", light},
        {Effect::Lights, "p1solve", light + "--sun-irradiance 0 --effects sky,multiple --sky 1",
         light + "--sun-irradiance 0 --sky 1", light},
        {Effect::Lights, "render", picture + "--effects multiple", picture + "--sun-irradiance 0", picture},
        {Effect::Emission, "p1solve", light, in("dark.vdb", light), in("glow.vdb", light)},
        {Effect::Emission, "render", picture, in("dark.vdb", picture), in("glow.vdb", picture)},
        {Effect::Sky, "p1solve", light, light + "--sky 0", light + "--sky 0.3"},
        {Effect::Sky, "render", picture + paths, picture + paths + "--sky 0", picture + paths + "--sky 0.3"},
        {Effect::Ground, "p1solve", light, "", light + "--ground-albedo 0.5"},
        {Effect::Ground, "render", picture + paths, "", picture + paths + "--ground-albedo 0.5"},
        {Effect::Solids, "illuminate", light, "", light + solid},
        {Effect::Solids, "p1solve", light, "", light + solid},
        {Effect::Solids, "render", picture, "", picture + solid},
        {Effect::Tint, "p1solve", light, in("white.vdb", light), in("red.vdb", light)},
        {Effect::Tint, "render", picture, in("white.vdb", picture), in("red.vdb", picture)},
        {Effect::Multiple, "p1solve", light + "--effects lights", light + "--albedo 0.001", light},
        {Effect::Multiple, "render", picture, picture + "--multiple --albedo 0.001", picture + "--multiple"},
        {Effect::Colour, "illuminate", light, "", light + "--extinction 0.3,0.4,0.5"},
        {Effect::Colour, "p1solve", light, "", light + "--albedo 0.9,0.8,0.7"},
        {Effect::Colour, "render", picture, "", picture + "--extinction 0.3,0.4,0.5"},
        {Effect::Anisotropy, "p1solve", light, "", light + "--g 0.5"},
        {Effect::Anisotropy, "render", picture + "--multiple", "", picture + "--multiple --g 0.5"},
        {Effect::Mixture, "p1solve", light, "", "ball.vdb thick.vdb --sun 0,1,0"},
        {Effect::Mixture, "render", picture, "", "ball.vdb thick.vdb --sun 0,1,0 --resolution 6"},
        {Effect::Periodic, "illuminate", in("slab.vdb", light), "", in("slab.vdb", light) + "--periodic xz"},
        {Effect::Periodic, "p1solve", in("slab.vdb", light), "", in("slab.vdb", light) + "--periodic xz"},
        {Effect::Periodic, "render", in("slab.vdb", picture), "", in("slab.vdb", picture) + "--periodic xz"},
    };
    return all;
}

/// The last of an option's values is in force.
std::string latest(const std::string& line)
{
    std::string text = line;
    for (const char* option : {"--extinction", "--albedo", "--g"})
        if (const size_t first = text.find(std::string(option) + " "); first != text.rfind(std::string(option) + " "))
            text.erase(first, text.find(' ', first + std::string(option).size() + 1) - first + 1);
    return text;
}

TEST_F(SceneEffects, OneThatIsOffHasNoEntriesFieldsAndBytes)
{
    const auto thick = ball("density", 5);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(2);
    medium.phase = PhaseFunction::henyey_greenstein(0.5);
    write_medium(*thick, medium);
    write_grid_file(scratch / "thick.vdb", file_of({thick}));
    std::set<Effect> known;
    for (const Row& row : rows()) {
        known.insert(row.effect);
        const std::string name = effect_names()[size_t(row.effect)].name;
        for (const std::string& line : {row.without, row.idle}) {
            if (line.empty()) continue;
            const nlohmann::json found = report(row.tool, latest(line))["effects"][name];
            EXPECT_EQ(found["on"], false) << row.tool << " " << line << found;
            for (const char* counter : {"entries", "fields", "bytes"})
                EXPECT_EQ(found[counter], 0) << counter << " of " << name << ": " << row.tool << " " << line;
            EXPECT_FALSE(found.contains("cpu_seconds")) << name << ": " << row.tool << " " << line;
        }
        const nlohmann::json found = report(row.tool, latest(row.on))["effects"][name];
        EXPECT_EQ(found["on"], true) << row.tool << " " << row.on << found;
        EXPECT_GT(double(found["entries"]) + double(found["fields"]), 0) << name << ": " << row.tool << " " << row.on;
    }
    EXPECT_EQ(known.size(), effect_names().size()) << "an effect without a row";
    // A grid that adds nothing is read, by way of a buffer of its bytes, and passed on; nothing is made of it.
    for (const Row& row : rows()) {
        if (row.idle.empty() || row.without.empty() || row.effect == Effect::Multiple) continue;
        const bool grid = row.effect == Effect::Emission || row.effect == Effect::Tint;
        const double own = grid ? double(filled("grid", Vec3f(1.0f))->memUsage()) : 0;
        const double without = least_memory(row.tool, latest(row.without)),
                     idle = least_memory(row.tool, latest(row.idle));
        EXPECT_LT(idle, 1.01 * without + 1.1 * own) << row.tool << " " << row.idle;
    }
}

TEST_F(SceneEffects, ExplainHasALineForEachBeforeTheRunAndForEachThatWasOnAfterIt)
{
    const nlohmann::json r =
        report("p1solve", "ball.vdb --extinction 0.5 --albedo 0.9 --sky 0.3 --sun 0,1,0 --lamp 9,9,9 "
                          "--lamp-intensity 0 --explain");
    const std::string said = r["said"];
    for (const EffectName& effect : effect_names()) {
        const bool on = r["effects"][effect.name]["on"];
        const std::string name = std::string("  ") + effect.name + " ";
        const size_t first = said.find(name);
        ASSERT_NE(first, std::string::npos) << effect.name << said;
        EXPECT_NE(said.find(on ? "on   " : "off  ", first), std::string::npos) << effect.name;
        EXPECT_EQ(said.find(name, first + 1) != std::string::npos, on) << effect.name << said;
    }
    EXPECT_NE(said.find("sun; lamp has no power"), std::string::npos) << said;
    EXPECT_EQ(std::string(report("p1solve", "ball.vdb --sun 0,1,0")["said"]).find("anisotropy"), std::string::npos);
}

TEST_F(SceneEffects, AThinMediumIsPassedOnWithTheShareThatIsLeftOut)
{
    const nlohmann::json r = report("p1solve", "ball.vdb --extinction 0.5 --albedo 0.001 --sun 0,1,0");
    const double share = r["effects"]["multiple"]["share"];
    EXPECT_GT(share, 0);
    EXPECT_LT(share, 0.001);
    EXPECT_NE(std::string(r["said"]).find("multiple scattering is left out"), std::string::npos) << r["said"];
    EXPECT_EQ(names(scratch / "out.vdb"), (Words{"density", "transmittance_sun"}));
    const auto file = read_grid_file(scratch / "out.vdb");
    EXPECT_NEAR(file.metadata->metaValue<double>("vdbcloud:multiple_left_out"), share, 1e-12);

    const std::string lit =
        stage("p1solve", scratch / "ball.vdb", "solved.vdb",
              {"-q", "--extinction", "0.5", "--albedo", "0.001", "--sun", "0,1,0", "--effects", "all"});
    EXPECT_EQ(names(lit).size(), 3u) << "phi is there";
    const std::vector<float> thin = picture(scratch / "out.vdb", {"-q", "--aov", "none"}),
                             solved = picture(lit, {"-q", "--aov", "none"});
    ASSERT_EQ(thin.size(), solved.size());
    double difference = 0, sum = 0;
    for (size_t k = 0; k < thin.size(); k += 4) {  // R
        difference += std::abs(double(thin[k] - solved[k]));
        sum += solved[k];
    }
    EXPECT_GT(sum, 0);
    EXPECT_LT(difference, 0.02 * sum);
    EXPECT_GT(difference, 0) << "the chain with phi shows more light";
    EXPECT_FALSE(picture(scratch / "out.vdb", {"-q", "--gather", "2", "--spp", "1"}).empty())
        << "paths end without phi";
    // A later solution takes the place of the note, and a thin medium that of the solution.
    const std::string thick = stage("p1solve", scratch / "out.vdb", "thick.vdb", {"-q", "--albedo", "0.9"});
    EXPECT_FALSE((*read_grid_file(thick).metadata)["vdbcloud:multiple_left_out"]);
    EXPECT_EQ(names(stage("p1solve", thick, "thin.vdb", {"-q", "--albedo", "0.001"})).size(), 2u);
}

TEST_F(SceneEffects, ALightWithoutPowerIsDescribedAndHasNoValues)
{
    report("illuminate", "ball.vdb --extinction 0.5 --sun 0,1,0 --lamp 9,9,9 --lamp-intensity 0");
    const auto file = read_grid_file(scratch / "out.vdb");
    const GridBasePtr lamp = find_grid(file, "transmittance_lamp");
    ASSERT_TRUE(lamp);
    EXPECT_EQ(lamp->activeVoxelCount(), 0u);
    // The same place with power: the grid is computed.
    const std::string in = scratch / "dim.vdb";
    write_grid_file(in, file);
    const Words bright{"-q", "--sun", "0,1,0", "--lamp", "9,9,9", "--lamp-intensity", "500"};
    const std::vector<float> seen = picture(in, bright),
                             fresh = picture(scratch / "ball.vdb", with(bright, {"--extinction", "0.5"}));
    ASSERT_FALSE(seen.empty());
    EXPECT_EQ(seen, fresh);
    EXPECT_NE(seen, picture(in, {"-q"}));
    const RunResult said = run({program("render"), in, "--sun", "0,1,0", "--lamp", "9,9,9", "--lamp-intensity", "500",
                                "--resolution", "2", "-o", scratch / "said.exr"});
    EXPECT_EQ(said.err.find("computed again"), std::string::npos) << "it never was: " << said.err;
    const auto again = read_grid_file(stage("p1solve", in, "lit.vdb", bright));
    EXPECT_GT(find_grid(again, "transmittance_lamp")->activeVoxelCount(), 0u);
    // Alone it lights nothing, and no program puts a sun in its place.
    const std::string dark = stage("illuminate", scratch / "ball.vdb", "dark_lamp.vdb",
                                   {"-q", "--extinction", "0.5", "--lamp", "9,9,9", "--lamp-intensity", "0"});
    const Words black_sky{"-q", "--extinction", "0.5", "--sky", "0"};
    for (const std::string& input : {dark, stage("p1solve", dark, "dark_lit.vdb", {"-q"}),
                                     stage("p1solve", scratch / "ball.vdb", "dark_sky.vdb", black_sky)}) {
        const std::vector<float> black = picture(input, {"-q", "--aov", "none"});
        for (size_t k = 0; k < black.size(); k += 4) ASSERT_EQ(black[k], 0) << input;
    }
}

TEST_F(SceneEffects, ALightThatBlackSolidsHideFromAllVoxelsIsNotSolvedFor)
{
    const std::string input =
        "ball.vdb --extinction 0.5 --albedo 0.9 --sun 0,1,0 --solid 'sphere;at=0,30,0;radius=20;colour=0' ";
    const nlohmann::json r = report("p1solve", input + "--sky 0.3");
    EXPECT_EQ(r["effects"]["lights"]["on"], false);
    EXPECT_EQ(r["effects"]["lights"]["entries"], 0);
    EXPECT_EQ(r["effects"]["lights"]["why"], "sun reaches no voxel");
    EXPECT_EQ(r["effects"]["multiple"]["on"], true) << "the sky lights the medium";
    const std::vector<float> chosen = picture(scratch / "out.vdb", {"-q"});
    report("p1solve", input + "--sky 0.3 --effects all");
    EXPECT_FALSE(chosen.empty());
    EXPECT_EQ(picture(scratch / "out.vdb", {"-q", "--effects", "all"}).size(), chosen.size());
    const nlohmann::json none = report("p1solve", input);
    EXPECT_EQ(none["effects"]["multiple"]["why"], "no light reaches the medium");
    // In sweeps a solid that is not black may send the light on.
    const nlohmann::json grey =
        report("p1solve", "ball.vdb --extinction 0.5 --sun 0,1,0 --solid 'sphere;at=0,30,0;radius=20' --iterations 1");
    EXPECT_EQ(grey["effects"]["lights"]["on"], true);
    EXPECT_EQ(grey["effects"]["multiple"]["on"], true);
}

TEST_F(SceneEffects, AListLeavesOutTheOthersInTheWholeChain)
{
    const std::string scene = scratch / "scene.toml";
    const auto chain = [&](const std::string& list, const std::string& input) {
        write_text(scene,
                   "[medium]\nextinction = 0.5\nalbedo = 0.9\n[[lights]]\nsun = [0, 1, 0]\n[accuracy]\neffects = \"" +
                       list + "\"\n");
        const Words words{"-q", "--scene", scene};
        const std::string lit = stage("illuminate", input, "lit.vdb", words);
        return picture(stage("p1solve", lit, "solved.vdb", words), words);
    };
    const std::string rich =
        stage("illuminate", scratch / "glow.vdb", "rich.vdb",
              {"-q", "--extinction", "0.5", "--sun", "0,1,0", "--solid", "sphere;at=0,9,0;radius=4"});
    EXPECT_EQ(chain("lights,multiple", rich), chain("lights,multiple", scratch / "ball.vdb"));
    EXPECT_EQ(chain("lights,multiple", rich), chain("auto", scratch / "ball.vdb"));
    EXPECT_NE(chain("lights,multiple,emission", rich), chain("lights,multiple", rich));
    EXPECT_NE(chain("lights,multiple,solids", rich), chain("lights,multiple", rich));
    EXPECT_NE(chain("lights", rich), chain("lights,multiple", rich));
    EXPECT_EQ(test::picture(scratch / "picture.exr").text("vdbcloud:left_out"),
              "emission (left out on request); solids (left out on request)");
}

TEST_F(SceneEffects, UnknownNamesAndContradictionsAreRefused)
{
    const std::string sky = stage("p1solve", scratch / "ball.vdb", "sky.vdb", {"-q", "--sky", "1"});
    const struct {
        Words words;
        const char* said;
    } table[] = {
        {{"p1solve", "--effects", "emision"}, "'emision': did you mean 'emission'?"},
        {{"p1solve", "--effects", "lights,,sky"}, "'': expected auto, all, or some of lights, emission"},
        {{"render", "--effects", "periodic"}, "'periodic' is a property of the medium"},
        {{"p1solve", "--accuracy-error", "2"}, "expected a share below 1, such as 2% or 0.02"},
        {{"p1solve", "--accuracy-error", "1%", "--effects", "all"},
         "--accuracy-error has no effect with --effects all"},
        {{"render", "--accuracy-error", "1%"}, "--accuracy-error has no effect without --multiple"},
        {{"render", "--multiple", "--effects", "lights"}, "--multiple has no effect"},
        {{"render", "--integrator", "path", "--effects", "lights"}, "with light paths, which hold all orders"},
        {{"illuminate", "--explain", "--quiet"}, "--explain has no effect with --quiet"},
    };
    for (const auto& wrong : table) {
        Words words{program(wrong.words[0]), scratch / "ball.vdb", "-o",
                    scratch / (wrong.words[0] == "render" ? "x.exr" : "x.vdb")};
        words.insert(words.end(), wrong.words.begin() + 1, wrong.words.end());
        const RunResult r = run(words);
        EXPECT_EQ(r.status, 2) << r.err;
        EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err;
    }
    const RunResult r =
        run({program("render"), sky, "--effects", "multiple", "-o", scratch / "x.exr", "--resolution", "4"});
    EXPECT_EQ(r.status, 2) << r.err;
    EXPECT_NE(r.err.find("multiple scattering was computed with a sky"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace vdbcloud::test
