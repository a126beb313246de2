// --scene: one file for all programs. Each takes its part, and each refuses what is no key of any.
#include "scene_file.h"
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

const Words readers{"fractalgen", "cloudsim", "vdbimport", "illuminate", "p1solve", "render"};

RunResult part(const std::string& tool, const std::string& scene, const Words& more = {})
{
    const Scratch scratch;
    write_text(scratch / "s.toml", scene);
    Words words{program(tool), "--scene", scratch / "s.toml", "--print-scene"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}

const std::string whole = R"([medium]
extinction = 80
albedo = [0.9, 1, 1]
up = "z"

[[lights]]
sun = [0.3, 1, 0.2]
irradiance = [1, 0.9, 0.8]

[sky]
zenith = 0.1

[solids]
ground-albedo = 0.3

[camera]
fov = 30

[picture]
exposure = 2

[accuracy]
iterations = 3
rays-per-voxel = 2
samples = 4
)";

TEST(SceneFile, EachProgramTakesItsPart)
{
    const std::string up = "[medium]\nup = \"z\"\n",
                      light = "[[lights]]\nsun = [0.3, 1, 0.2]\nirradiance = [1, 0.9, 0.8]\n",
                      medium = "extinction = 80\nalbedo = [0.9, 1, 1]\n";
    const std::map<std::string, std::string> expected{
        {"cloudsim", up},
        {"fractalgen", "[medium]\nup = \"z\"\n" + medium},
        {"vdbimport", "[medium]\nup = \"z\"\n" + medium},
        {"illuminate", "[medium]\nup = \"z\"\n" + medium + light + "[accuracy]\nrays-per-voxel = 2\n"},
        {"p1solve", "[medium]\nup = \"z\"\n" + medium + light +
                        "[sky]\nzenith = 0.1\n[solids]\nground-albedo = 0.3\n[accuracy]\niterations = 3\n"
                        "rays-per-voxel = 2\n"},
        {"render", "[medium]\n" + medium + "up = \"z\"\n" + light +
                       "[sky]\nzenith = 0.1\n[solids]\nground-albedo = 0.3\n[camera]\nfov = 30\n[picture]\n"
                       "exposure = 2\n[accuracy]\nsamples = 4\n"}};
    for (const auto& [tool, text] : expected) {
        const RunResult r = part(tool, whole);
        EXPECT_EQ(r.status, 0) << r.err;
        EXPECT_EQ(r.out, text) << tool;
    }
}

TEST(SceneFile, ThePartIsOneTextForEachMeaning)
{
    const std::string other = "accuracy = {samples = 4.0e0, rays-per-voxel = +2, iterations = 3}\n"
                              "[picture] # tones\nexposure = 2.0\n[camera]\n'fov' = 3e1\n[solids]\n"
                              "ground-albedo = \"0.3\"\n[sky]\nzenith = \"0.1\"\n"
                              "[[lights]]\nirradiance = \"1,0.9,0.8\"\nsun = [0.3,\n1,0.2]\n"
                              "[medium]\nup = \"Z\"\nalbedo = [[0.9, 1, 1]]\nextinction = 80.0\n";
    for (const std::string& tool : readers) {
        const std::string text = part(tool, whole).out;
        EXPECT_EQ(part(tool, text).out, text) << tool;
        EXPECT_EQ(part(tool, other).out, text) << tool << part(tool, other).err;
    }
}

TEST(SceneFile, EveryProgramRefusesWhatNoProgramHas)
{
    const struct {
        const char *text, *said;
    } table[] = {
        {"\n[skyy]\nzenith = 1", "s.toml: line 2: unknown section [skyy]; did you mean 'sky'?"},
        {"[sky]\nzenit = 1", "line 2: unknown key 'zenit' in [sky]; did you mean 'zenith'?"},
        {"[sky]\nfov = 30", "line 2: unknown key 'fov' in [sky]; expected 'fov' in [camera]"},
        {"[camera]\nsky-zenith = 1", "line 2: unknown key 'sky-zenith' in [camera]; expected 'zenith' in [sky]"},
        {"[medium]\ndensity = \"d\"", "line 2: unknown key 'density' in [medium]; "},
        {"[camera]\nthreads = 2", "line 2: unknown key 'threads' in [camera]"},
        {"fov = 3", "line 1: 'fov' is in no section; expected 'fov' in [camera]"},
        {"qqq = 3", "line 1: 'qqq' is in no section; expected a line [section] before it"},
        {"[lights]\nsun = [0,1,0]", "line 1: 'lights': expected a section [[lights]] for each light"},
        {"lights = 3", "line 1: 'lights': expected a section [[lights]] for each light"},
        {"lights = [1, 2]", "line 1: 'lights': expected a section [[lights]] for each light"},
        {"[[sky]]\nzenith = 1", "line 1: 'sky': expected one section [sky]"},
        {"sky = 1", "line 1: 'sky': expected one section [sky]"},
        {"[sky.zenith]\nx = 1", "line 1: 'zenith' is a table within [sky]: expected lines key = value"},
        {"[[lights]]\nirradiance = 1", "line 1: [[lights]]: expected one of the keys sun, lamp"},
        {"[[lights]]\nirradance = 1", "line 2: unknown key 'irradance' in [[lights]]"},
        {"[[lights]]\nsun = [0,1,0]\nlamp = [0,1,0]", "line 3: 'lamp': this light is a sun already"},
        {"[[lights]]\nsun = [0,1,0]\nintensity = 3", "line 3: unknown key 'intensity' of a sun; expected irradiance, "},
        {"[[lights]]\nsun = [[0,1,0],[1,1,1]]", "line 2: 'sun': expected one value"},
        {"[sky]\nhaze = 1\n[sky]\nhaze = 1", "line 3: 'sky' is set twice"},
        {"[sky]\nhaze = 1\nhaze = 1", "line 3: 'haze' is set twice"},
        {"[sky]\nhaze = nan", "line 2: 'haze': expected a finite number; text goes between quotes"},
        {"[sky]\nhaze = 1e400", "line 2: floating-point: '1e400' could not be interpreted"},
        {"[sky]\nhaze = 1e31", "line 2: [sky] haze: '1e+31': expected numbers of a size up to 1e+30"},
        {"[sky]\nhaze", "line 2: key-value pair"},
        {"\xff", "line 1: Encountered invalid utf-8 sequence"},
    };
    size_t row = 0;
    for (const auto& wrong : table) {
        // One reader serves all programs: a few rows for each program, the others in turn.
        const Words tools = row < 2 ? readers : Words{readers[row % readers.size()]};
        ++row;
        for (const std::string& tool : tools) {
            const RunResult r = part(tool, wrong.text);
            EXPECT_EQ(r.status, 2) << tool << ": " << wrong.text;
            EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err << "expected: " << wrong.said;
            EXPECT_NE(r.err.find("s.toml: "), std::string::npos) << r.err;
            EXPECT_EQ(r.err.find('\n'), r.err.size() - 1) << r.err;
        }
    }
}

TEST(SceneFile, EveryProgramRefusesAWrongValue)
{
    for (const char* wrong :
         {"[medium]\nalbedo = 2", "[medium]\nperiodic = \"xyz\"", "[medium]\nphase = \"mie\"", "[medium]\nup = \"x\"",
          "[[lights]]\nsun = [0, 1]", "[[lights]]\nsun = [0, 1, 0]\nirradiance = -1", "[sky]\nzenith = -1",
          "[solids]\nground-albedo = 1.5", "[camera]\nfov = 400", "[camera]\nposition = 1",
          "[picture]\nresolution = \"axb\"", "[picture]\nresolution = \"1x2x3\"", "[picture]\ncrop = \"1,2,3\"",
          "[picture]\nbackground = \"blue\"", "[picture]\npng-bits = 7", "[accuracy]\nrung = 9",
          "[accuracy]\niterations = 1.5", "[accuracy]\ncertify = \"soon\"", "[accuracy]\nshadow-rays = 1"})
        for (const std::string& tool : readers) {
            const RunResult r = part(tool, std::string("\n") + wrong);
            EXPECT_EQ(r.status, 2) << tool << ": " << wrong;
            EXPECT_NE(r.err.find("s.toml: line "), std::string::npos) << r.err;
        }
}

TEST(SceneFile, AFlagWinsThenTheConfiguration)
{
    const Scratch scratch;
    write_text(scratch / "s.toml", whole);
    write_text(scratch / "c.toml", "extinction = \"70\"\nfov = 40\n");
    const auto settings = [&](Words words) {
        words.insert(words.begin(), {program("render"), "--scene", scratch / "s.toml"});
        words.push_back("--print-config");
        const RunResult r = run(words);
        EXPECT_EQ(r.status, 0) << r.err;
        return r.out;
    };
    const auto expect = [](const std::string& text, const Words& lines) {
        for (const std::string& line : lines)
            EXPECT_NE(text.find("\n" + line + "\n"), std::string::npos) << line << text;
    };
    expect(settings({}), {"extinction = 80", "fov = 30", "exposure = 2", "sun = [[0.3, 1, 0.2]]"});
    expect(settings({"--config", scratch / "c.toml"}), {"extinction = 70", "fov = 40", "exposure = 2"});
    expect(settings({"--config", scratch / "c.toml", "--fov", "50"}), {"extinction = 70", "fov = 50", "exposure = 2"});
    // A sun of the command line takes the place of all suns, and their parameters go with them.
    const std::string sun = settings({"--sun", "0,1,0"});
    expect(sun, {"sun = [[0, 1, 0]]", "# sun-irradiance ="});
    expect(settings({"--sun-irradiance", "2"}), {"sun = [[0.3, 1, 0.2]]", "sun-irradiance = [2]"});
}

TEST(SceneFile, ALightWithoutAParameterHasItsDefault)
{
    const std::string lights =
        "[[lights]]\nsun = [0, 1, 0]\n[[lights]]\nlamp = [1, 2, 3]\n"
        "[[lights]]\nsun = [1, 0, 0]\ndiameter = 2\n[[lights]]\nsun = [0, 0, 1]\nirradiance = 7\n";
    const std::string all =
        "[[lights]]\nsun = [0, 1, 0]\nirradiance = 1\ndiameter = 0\n[[lights]]\nsun = [1, 0, 0]\nirradiance = 1\n"
        "diameter = 2\n[[lights]]\nsun = [0, 0, 1]\nirradiance = 7\ndiameter = 0\n[[lights]]\nlamp = [1, 2, 3]\n";
    EXPECT_EQ(part("illuminate", lights).out, all);
}

TEST(SceneFile, WhatThisRunDoesNotUseIsLeftOutAndARungIsBeaten)
{
    const Scratch scratch;
    // --step has no effect without --integrator steps, --png-bits none without a .png.
    write_text(scratch / "s.toml",
               "[camera]\nfov = 30\northo-width = 3\n[picture]\npng-bits = 16\nresolution = \"4\"\n"
               "[accuracy]\nstep = 0.1\nrung = 5\nparts = 2\nshadow-rays = true\nfilter = \"box\"\n");
    ASSERT_EQ(run({program("fractalgen"), "-q", "--size", "8", "-o", scratch / "c.vdb"}).status, 0);
    const RunResult r = run({program("render"), "-q", scratch / "c.vdb", "--scene", scratch / "s.toml", "--json", "-",
                             "--integrator", "cells", "-o", scratch / "a.exr"});
    ASSERT_EQ(r.status, 0) << r.err;
    const nlohmann::json parameters = nlohmann::json::parse(r.out)["parameters"];
    EXPECT_EQ(parameters["parts"], 2);
    EXPECT_EQ(parameters["step"], 0.5) << "the default: left out";
    EXPECT_EQ(parameters["fov"], 30);
    EXPECT_EQ(parameters["shadow-rays"], true);
    const RunResult flag = run({program("render"), scratch / "c.vdb", "--scene", scratch / "s.toml", "--step", "0.1",
                                "--integrator", "cells", "-o", scratch / "a.exr"});
    EXPECT_EQ(flag.status, 2);
    EXPECT_NE(flag.err.find("--step has no effect"), std::string::npos) << flag.err;
}

TEST(SceneFile, PrintSceneNeedsAScene)
{
    const RunResult r = run({program("render"), "--print-scene"});
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("--print-scene has no effect without --scene"), std::string::npos) << r.err;
}

TEST(SceneFile, AFileThatCannotBeReadIsStatusOne)
{
    const Scratch scratch;
    for (const std::string& path : {scratch / "missing.toml", scratch.path(), std::string("/dev/zero")}) {
        const RunResult r = run({program("illuminate"), "--scene", path, "--print-scene"});
        EXPECT_EQ(r.status, 1) << path;
        EXPECT_NE(r.err.find(path + ": "), std::string::npos) << r.err;
    }
}

/// "[sky] zenith" of each "(...; scene [sky] zenith)" in a program's help.
std::set<std::string> keys_in_help(const std::string& tool)
{
    std::istringstream in(run({program(tool), "--help"}).out);
    std::string text;
    for (std::string word; in >> word;) text += word + " ";
    std::set<std::string> keys;
    const std::string before = "scene [";
    for (size_t at = 0; (at = text.find(before, at)) != std::string::npos; ++at)
        if (text[at - 1] == ' ' || text[at - 1] == '(') keys.insert(text.substr(at + 6, text.find(')', at) - at - 6));
    return keys;
}

TEST(SceneFile, KeysOfAllProgramsAreKnownToAllAndOfOneKind)
{
    std::map<std::string, std::string> known;
    for (const auto& program : app::scene_programs()) {
        std::set<std::string> own;
        for (const app::SceneKey& key : program->scene_keys()) {
            const std::string name = shown(key), type = key.option.cli()->get_type_name();
            EXPECT_TRUE(own.insert(name + " of " + key.light).second) << program->get_name() << ": two keys " << name;
            const auto [same, first] = known.emplace(name + " of " + key.light, type);
            EXPECT_EQ(same->second, type) << program->get_name() << " reads " << name << " otherwise";
        }
        EXPECT_EQ(keys_in_help(program->get_name()).empty(), false);
    }
    std::set<std::string> names;
    for (const auto& [name, type] : known) names.insert(name.substr(0, name.find(" of ")));
    for (const std::string& tool : readers)
        for (const std::string& key : keys_in_help(tool)) EXPECT_TRUE(names.count(key)) << tool << ": " << key;
}

TEST(SceneFile, EveryOptionOfAPictureIsAKey)
{
    // Options that belong to a run, not to the picture: files, more than one result, parts of a job.
    const std::set<std::string> of_a_run{
        "input",         "--output",     "--density",      "--flux-map",     "--heating",
        "--series",      "--galerkin",   "--least-albedo", "--series-raw",   "--allow-unconverged",
        "--voxel-error", "--spp-offset", "--start-from",   "--start-seconds"};
    for (const auto& program : app::scene_programs()) {
        std::set<const CLI::Option*> keys;
        for (const app::SceneKey& key : program->scene_keys()) keys.insert(key.option.cli());
        for (const CLI::Option* option : program->get_options()) {
            if (!option->get_configurable() || keys.count(option) || of_a_run.count(option->get_name())) continue;
            ADD_FAILURE() << program->get_name() << " " << option->get_name()
                          << ": expected .scene(SECTION) at its declaration, or a name in the list of this test";
        }
    }
}

TEST(SceneFile, TheDocumentHasEveryKey)
{
    const std::string tables = app::scene_tables(app::scene_programs()),
                      document = read_text(VDBCLOUD_SOURCE "/docs/scene.md");
    const size_t at = document.find("### [medium]");
    ASSERT_NE(at, std::string::npos);
    const bool same = document.substr(at) + "\n" == tables;
    if (!same) write_text("scene_tables.md", tables);
    EXPECT_TRUE(same)
        << "docs/scene.md: expected from '### [medium]' on what scene_tables.md in the folder of the test has";
}

}  // namespace
}  // namespace vdbcloud::test
