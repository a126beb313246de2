// render --multiple has the pixels of the chain of programs, and a picture without it says what it leaves out.
#include "stages.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {
namespace {

class Multiple : public Stages {
protected:
    std::string cloud() { return stage("fractalgen", "", "cloud.vdb", {"-q", "--size", "24", "--seed", "7"}); }
};

TEST_F(Multiple, HasThePixelsOfTheChain)
{
    for (const std::string more : {"", "[sky]\nzenith = [0.1, 0.2, 0.4]\nhorizon = 0.3\n",
                                   "[solids]\nsolid = \"sphere;at=0.5,0.8,0.5;radius=0.3\"\n"}) {
        write_text(scratch / "scene.toml",
                   std::string("[medium]\nextinction = 20\nalbedo = [0.9, 0.99, 0.999]\ng = 0.85\n"
                               "[[lights]]\nsun = [0.3, 1, 0.2]\nirradiance = [3, 2, 1]\n[accuracy]\nsamples = 2\n") +
                       more);
        const Words scene{"-q", "--scene", scratch / "scene.toml"};
        const std::string density = cloud(), light = stage("illuminate", density, "light.vdb", scene);
        Words sweeps = scene, multiple = scene;
        sweeps.insert(sweeps.end(), {"--iterations", "3"});
        multiple.push_back("--multiple");
        const std::vector<float> chain = picture(stage("p1solve", light, "lit.vdb", sweeps), scene);
        ASSERT_FALSE(chain.empty());
        EXPECT_EQ(picture(density, multiple), chain) << more;
        EXPECT_EQ(picture(light, multiple), chain) << more;
        EXPECT_NE(picture(density, scene), chain);
    }
}

TEST_F(Multiple, IsRefusedWhereItHasNoEffect)
{
    const std::string density = cloud(), light = stage("illuminate", density, "light.vdb", {"-q"}),
                      lit = stage("p1solve", density, "lit.vdb", {"-q"});
    const struct {
        Words words;
        const char* said;
    } table[] = {
        {{lit, "--multiple"}, "--multiple has no effect without a file without multiple scattering"},
        {{density, "--multiple", "--integrator", "path"}, "--multiple has no effect with --integrator path"},
        {{density, light, "--multiple"}, "several files"},
    };
    for (const auto& wrong : table) {
        Words words{program("render"), "-o", scratch / "x.exr", "--resolution", "4"};
        words.insert(words.end(), wrong.words.begin(), wrong.words.end());
        const RunResult r = run(words);
        EXPECT_EQ(r.status, 2) << r.err;
        EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err;
    }
    const RunResult dry =
        run({program("render"), density, "--multiple", "--dry-run", "-o", scratch / "x.exr", "--resolution", "4"});
    EXPECT_EQ(dry.status, 0) << dry.err;
}

TEST_F(Multiple, WithoutItThePictureSaysWhichShareIsLeftOut)
{
    const std::string density = cloud();
    double last = 0;
    for (const char* extinction : {"0.3", "3", "30"}) {
        const RunResult r = run({program("render"), density, "--sun", "0,1,0", "--extinction", extinction, "--albedo",
                                 "0.99", "--json", scratch / "r.json", "-o", scratch / "x.exr", "--resolution", "4"});
        ASSERT_EQ(r.status, 0) << r.err;
        const nlohmann::json left = nlohmann::json::parse(read_text(scratch / "r.json"))["left_out"];
        const double share = left["share"];
        EXPECT_GT(share, last);
        EXPECT_LT(share, 1);
        EXPECT_LE(left["error"], 0.01);
        const std::string said = "light that is scattered again, " + std::to_string(std::lround(100 * share)) + " %";
        EXPECT_NE(r.err.find(said), std::string::npos) << r.err << said;
        last = share;
    }
    EXPECT_GT(last, 0.8);
    const std::string lit = stage("p1solve", density, "lit.vdb", {"-q", "--sun", "0,1,0"});
    const RunResult r = run({program("render"), lit, "-o", scratch / "x.exr", "--resolution", "4"});
    EXPECT_EQ(r.err.find("left out"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace vdbcloud::test
