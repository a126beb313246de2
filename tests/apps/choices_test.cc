// What a user chose at one stage holds at the next: the density, the axis that points up.
#include "stages.h"

#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/optics/collided_light.h"

namespace vdbcloud::test {
namespace {

class Choices : public Stages {
protected:
    /// Two balls that may be the density; "density" is the one taken by name.
    std::string two_densities()
    {
        return write_ball("two.vdb", "density", openvdb::GRID_FOG_VOLUME, {ball("smoke", 4)});
    }
    /// A ball in a file that says which axis is up, and nothing if `up` is empty.
    std::string ball_with(const std::string& name, const std::string& up)
    {
        GridFile file = file_of({ball("density", 5)});
        if (!up.empty()) set_text(*file.metadata, schema::up_axis, up);
        write_grid_file(scratch / name, file);
        return scratch / name;
    }
    RunResult tool(Words words, const Words& options)
    {
        words[0] = program(words[0]);
        return run(with(words, options));
    }
    static std::string digest_behind(const std::string& path, const std::string& grid)
    {
        const GridFile file = read_grid_file(path);
        const GridBasePtr found = find_grid(file, grid);
        return found ? get_text(*found, schema::density_digest, "") : "no grid " + grid;
    }
    static std::string up_in(const std::string& path)
    {
        return get_text(*read_grid_file(path).metadata, schema::up_axis, "");
    }
};

TEST_F(Choices, TheDensityOfOneStageIsThatOfTheNext)
{
    const std::string lit = stage("illuminate", two_densities(), "lit.vdb", with(medium, {"--density", "smoke"}));
    const std::string solved = stage("p1solve", lit, "solved.vdb", {"--albedo", "0.9"});
    const std::string smoke = grid_digest(*ball("smoke", 4)), density = grid_digest(*ball("density", 5));
    EXPECT_EQ(digest_behind(lit, "transmittance_sun"), smoke);
    EXPECT_EQ(digest_behind(solved, "phi"), smoke);
    const auto found = picture(solved, {}), asked = picture(solved, {"--density", "smoke"});
    EXPECT_EQ(found, asked);
    EXPECT_GT(*std::max_element(found.begin(), found.end()), 0.01f);

    const std::string other = stage("p1solve", lit, "other.vdb", with(medium, {"--density", "density"}));
    EXPECT_EQ(digest_behind(other, "phi"), density) << "a new choice replaces the old one";
    EXPECT_EQ(picture(other, {}), picture(other, {"--density", "density"}));
}

TEST_F(Choices, ADensityThatIsGoneIsSaid)
{
    const std::string lit = stage("illuminate", two_densities(), "lit.vdb", with(medium, {"--density", "smoke"}));
    GridFile file = read_grid_file(lit);
    remove_grids(file, [](const std::string& name) { return name == "smoke"; });
    write_grid_file(scratch / "gone.vdb", file);
    const RunResult result = tool({"p1solve", scratch / "gone.vdb", "-o", scratch / "o.vdb"}, medium);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("took grid 'smoke' for the density, and it is not there"), std::string::npos)
        << result.err;
}

TEST_F(Choices, AFileThatDoesNotSayWhatIsUpGetsOneLine)
{
    const std::string silent = ball_with("silent.vdb", ""), note = "does not say which axis is up";
    const RunResult first = tool({"illuminate", silent, "-o", scratch / "a.vdb"}, {});
    EXPECT_NE(first.err.find(note), std::string::npos) << first.err;
    const RunResult second = tool({"p1solve", scratch / "a.vdb", "-o", scratch / "b.vdb"}, {"--sky", "1"});
    EXPECT_EQ(second.err.find(note), std::string::npos) << second.err;
    const RunResult third = tool({"render", scratch / "b.vdb", "-o", scratch / "c.exr"}, {"--resolution", "4"});
    EXPECT_EQ(third.err.find(note), std::string::npos) << third.err;
    EXPECT_EQ(up_in(scratch / "b.vdb"), "Y");

    const RunResult needless = tool({"illuminate", silent, "-o", scratch / "d.vdb"}, {"--sun", "0,1,0"});
    EXPECT_EQ(needless.err.find(note), std::string::npos) << "nothing here depends on it: " << needless.err;
    EXPECT_EQ(up_in(scratch / "d.vdb"), "");
    const RunResult asked = tool({"illuminate", silent, "-o", scratch / "e.vdb"}, {"--up", "z", "--sun", "0,1,0"});
    EXPECT_EQ(asked.err.find(note), std::string::npos) << asked.err;
    EXPECT_EQ(up_in(scratch / "e.vdb"), "Z");
}

TEST_F(Choices, ASkyStandsOverTheAxisThatTheFileSays)
{
    const Words sky{"--sky-zenith", "1",   "--sky-horizon", "0.5", "--sky-ground", "0",
                    "--albedo",     "0.9", "--extinction",  "3"};
    const std::string silent = ball_with("silent.vdb", "");
    const std::string z = stage("p1solve", silent, "z.vdb", with(sky, {"--up", "z"}));
    EXPECT_EQ(up_in(z), "Z");
    // The ball is symmetric: under a sky over z it is brighter at its top along z, as much as along y under one over y.
    const std::string y = stage("p1solve", silent, "y.vdb", with(sky, {"--up", "y"}));
    const auto phi = [](const std::string& path, const openvdb::Coord& at) {
        const GridFile file = read_grid_file(path);
        return fluence(read_collided_light(file, PhaseFunction(), {}))->tree().getValue(at)[0];
    };
    const float top = phi(z, {0, 0, 4}), base = phi(z, {0, 0, -4});
    EXPECT_GT(top, 1.2f * base);
    EXPECT_NEAR(phi(y, {0, 4, 0}) / top, 1, 1e-4) << "the solver's tolerance is 1e-6";
    EXPECT_NEAR(phi(y, {0, -4, 0}) / base, 1, 1e-4);

    EXPECT_EQ(tool({"render", z, "-o", scratch / "p.exr"}, {"--resolution", "4"}).status, 0);
    const RunResult turned = tool({"render", z, "-o", scratch / "p.exr"}, {"--resolution", "4", "--up", "y"});
    EXPECT_EQ(turned.status, 2);
    EXPECT_NE(turned.err.find("under a sky over the axis 0,0,1"), std::string::npos) << turned.err;
    const RunResult other = tool({"render", z, "-o", scratch / "p.exr"}, {"--resolution", "4", "--sky-zenith", "2"});
    EXPECT_EQ(other.status, 0);
    EXPECT_NE(other.err.find("another sky lit the medium"), std::string::npos) << other.err;
}

TEST_F(Choices, InputsThatDisagreeOnWhatIsUpAreRefused)
{
    const std::string y = ball_with("y.vdb", "Y"), z = ball_with("z.vdb", "Z");
    const Words small{"--resolution", "4", "--sun", "0,1,0"};
    const RunResult both = tool({"render", y, z, "-o", scratch / "p.exr"}, small);
    EXPECT_EQ(both.status, 2);
    EXPECT_NE(both.err.find("choose with --up"), std::string::npos) << both.err;
    EXPECT_EQ(tool({"render", y, z, "-o", scratch / "p.exr"}, with(small, {"--up", "y"})).status, 0);
}

TEST_F(Choices, AnEnvelopeKeepsItsSpace)
{
    GridFile deck = file_of({ball("density", 6)});
    set_text(*deck.metadata, schema::up_axis, "Z");
    set_number(*deck.metadata, schema::meters_per_unit, 25);
    write_grid_file(scratch / "deck.vdb", deck);
    const Words of_deck{"--envelope-from", scratch / "deck.vdb", "--size", "16"};
    const GridFile cloud = read_grid_file(stage("fractalgen", "", "cloud.vdb", of_deck));
    EXPECT_EQ(read_up_axis(*cloud.metadata), UpAxis::Z);
    EXPECT_EQ(get_number(*cloud.metadata, schema::meters_per_unit, 0), 25);
    const GridFile asked = read_grid_file(stage("fractalgen", "", "asked.vdb", with(of_deck, {"--up", "y"})));
    EXPECT_EQ(read_up_axis(*asked.metadata), UpAxis::Y);
}

TEST_F(Choices, AnInputAndAnEnvelopeThatContradictEachOtherAreRefused)
{
    const std::string y = ball_with("y.vdb", "Y"), z = ball_with("z.vdb", "Z"), none = ball_with("none.vdb", "");
    GridFile feet = read_grid_file(y);
    set_number(*feet.metadata, schema::meters_per_unit, 0.3048);
    write_grid_file(scratch / "feet.vdb", feet);
    set_number(*feet.metadata, schema::meters_per_unit, 1);
    write_grid_file(scratch / "metres.vdb", feet);
    const auto filled = [&](const std::string& input, const std::string& envelope, const Words& more = {}) {
        return tool({"fractalgen", input, "--envelope-from", envelope, "--size", "12", "-o", scratch / "f.vdb"}, more);
    };
    EXPECT_NE(filled(y, z).err.find("choose with --up"), std::string::npos);
    EXPECT_EQ(filled(y, z).status, 2);
    EXPECT_EQ(filled(y, z, {"--up", "Z"}).status, 0);
    EXPECT_EQ(read_up_axis(*read_grid_file(scratch / "f.vdb").metadata), UpAxis::Z);
    const std::string feet_path = scratch / "feet.vdb", metres = scratch / "metres.vdb";
    EXPECT_NE(filled(feet_path, metres).err.find("meters_per_unit 0.3048"), std::string::npos);
    EXPECT_EQ(filled(feet_path, metres).status, 2);
    EXPECT_EQ(filled(none, feet_path).status, 0);
    EXPECT_EQ(get_number(*read_grid_file(scratch / "f.vdb").metadata, schema::meters_per_unit, 0), 0.3048);
}

}  // namespace
}  // namespace vdbcloud::test
