// Which lights several files have together: what each is counts, and neither its name nor the order of files.
#include "several_inputs.h"

namespace vdbcloud::test {
namespace {

TEST_F(SeveralInputs, LightsAreWhatTheyAreNotWhatTheyAreCalled)
{
    write("low.vdb", body(1));
    write("high.vdb", moved(body(2), Vec3d(0, 4, 0)));
    const std::string up = " --sun 0,1,0 --sun-irradiance 2",
                      both = " --sun 0,1,0 --sun 1,1,0 --sun-irradiance 2 --sun-irradiance 1",
                      turned = " --sun 1,1,0 --sun 0,1,0 --sun-irradiance 1 --sun-irradiance 2";
    done("illuminate", "low.vdb" + both + " -o a.vdb");
    done("illuminate", "high.vdb" + both + " -o b.vdb");
    done("illuminate", "high.vdb" + turned + " -o c.vdb");
    done("illuminate", "high.vdb" + up + " -o d.vdb");
    const double expected = mean("a.vdb b.vdb", "");
    EXPECT_GT(expected, 0.01);
    // To rounding of the sum: each light is there once.
    EXPECT_NEAR(mean("a.vdb c.vdb", "") / expected, 1, 1e-6) << "names that are swapped";
    EXPECT_NEAR(mean("a.vdb d.vdb", "") / expected, 1, 1e-6) << "a light that has another name there";
    EXPECT_NEAR(mean("d.vdb a.vdb", "") / expected, 1, 1e-6);
    for (const char* program : {"illuminate", "p1solve"}) {
        done(program, std::string("a.vdb b.vdb -o joined.vdb"));
        done(program, std::string("a.vdb c.vdb -o swapped.vdb"));
        EXPECT_TRUE(equal("joined.vdb", "swapped.vdb")) << program;
    }
    // The order of inputs decides nothing: one input has the other's sun under a name that the other gives to its own.
    done("illuminate", "high.vdb --sun 1,1,0 --sun 0,1,0 --sun-irradiance 1 --sun-irradiance 2 -o e.vdb");
    done("illuminate", "low.vdb" + up + " -o f.vdb");
    EXPECT_NEAR(mean("e.vdb f.vdb", "") / expected, 1, 1e-6);
    EXPECT_NEAR(mean("f.vdb e.vdb", "") / expected, 1, 1e-6);
    done("illuminate", "low.vdb --sun 0,1,0 --sun-irradiance 3 -o g.vdb");
    for (const char* both_ways : {"f.vdb g.vdb", "g.vdb f.vdb"})
        EXPECT_NE(refused("render", std::string(both_ways) + " -o x.exr").find("of 2,2,2' "), std::string::npos);
    // A file twice has its light once.
    EXPECT_EQ(lights_of(read_grid_file(path("f.vdb"))).size(), 1u);
    done("illuminate", "f.vdb f.vdb -o twice.vdb");
    EXPECT_EQ(lights_of(read_grid_file(path("twice.vdb"))).size(), 1u);
    // A light that is asked for counts once, and a solution's file has the lights of the solution.
    done("illuminate", "e.vdb" + up + " -o again.vdb");
    EXPECT_EQ(lights_of(read_grid_file(path("again.vdb"))).size(), 1u);
    done("p1solve", "a.vdb --sun 1,1,0 --albedo 0.5 -o other.vdb");
    EXPECT_EQ(lights_of(read_grid_file(path("other.vdb"))).size(), 1u);
    EXPECT_GT(mean("other.vdb", ""), 0);
    // One input, whose suns are asked for in the other order: its grids serve.
    const RunResult again = run_line("render", "a.vdb" + turned + " --resolution 24 -o again.exr");
    EXPECT_EQ(again.status, 0);
    EXPECT_EQ(again.err.find("computed again"), std::string::npos) << again.err;
    EXPECT_NEAR(mean("a.vdb", turned) / mean("a.vdb", both), 1, 1e-6);
    done("p1solve", "a.vdb" + turned + " -o solved.vdb");
    EXPECT_EQ(lights_of(read_grid_file(path("solved.vdb"))).size(), 2u) << "no grid is made twice";
}

TEST_F(SeveralInputs, LightsOfAllInputsAreKeptAndOneNameIsOneLight)
{
    write("a.vdb", body(1));
    write("b.vdb", moved(body(2), Vec3d(0, 3, 0)));
    done("illuminate", "-q a.vdb --sun 0,1,0 -o sun.vdb");
    done("illuminate", "-q b.vdb --lamp 0,9,0 -o lamp.vdb");
    done("illuminate", "-q b.vdb --sun 1,0,0 -o other.vdb");
    for (const char* name : {"illuminate", "p1solve"}) {
        const std::string said = done(name, "sun.vdb lamp.vdb -o both.vdb");
        const GridFile both = read_grid_file(path("both.vdb"));
        const auto lights = lights_of(both);
        ASSERT_EQ(lights.size(), 2u) << name;
        EXPECT_EQ(lights[0].name, "lamp");
        EXPECT_EQ(lights[1].name, "sun");
        const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(both, "density"));
        for (const Light& light : lights) {
            const auto grid = find_grid(both, transmittance_name(light));
            EXPECT_GT(grid->activeVoxelCount(), density->activeVoxelCount()) << "on all voxels and their fringe";
        }
        const std::string sentence = refused(name, "sun.vdb other.vdb -o no.vdb");
        EXPECT_NE(sentence.find("other.vdb"), std::string::npos) << sentence;
        EXPECT_NE(sentence.find("--sun"), std::string::npos) << sentence;
        done(name, "-q sun.vdb other.vdb --sun 0,1,0 -o asked.vdb");
    }
    refused("render", "sun.vdb other.vdb -o no.exr");
}

}  // namespace
}  // namespace vdbcloud::test
