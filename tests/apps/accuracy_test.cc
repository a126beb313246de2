// The figures that bound the error of a result, along the chain: in files, on the terminal, in the picture.
#include "stages.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/accuracy.h"
#include "vdbcloud/grid/grid_file.h"

namespace vdbcloud::test {
namespace {

class AccuracyOfResults : public Stages {
protected:
    /// What a program says on standard error.
    std::string said(const Words& words)
    {
        const RunResult result = run(words);
        EXPECT_EQ(result.status, 0) << result.err;
        return result.err;
    }
    /// The figures in the metadata of a grid, as a text.
    std::string stored(const std::string& file, const std::string& grid)
    {
        const auto found = find_grid(read_grid_file(scratch / file), grid);
        return found ? text_of(read_accuracy(*found)) : "no grid " + grid;
    }
};

TEST_F(AccuracyOfResults, TravelFromTheStageThatMadeThemIntoThePicture)
{
    const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const std::string lit =
        said({program("illuminate"), input, "--extinction", "3", "--sun", "0.3,1,0.2", "-o", scratch / "lit.vdb"});
    const std::string of_light = stored("lit.vdb", "transmittance_sun");
    EXPECT_EQ(of_light.rfind("mean transmittance error ", 0), 0u) << of_light;
    EXPECT_NE(lit.find("accuracy of transmittance_sun: " + of_light + "\n"), std::string::npos) << lit;

    const std::string solved = said({program("p1solve"), scratch / "lit.vdb", "--g", "0.5", "-o", scratch / "p.vdb"});
    const std::string of_phi = stored("p.vdb", "phi");
    EXPECT_EQ(of_phi.rfind("residual ", 0), 0u) << of_phi;
    EXPECT_NE(of_phi.find(", defect "), std::string::npos) << of_phi;
    EXPECT_EQ(stored("p.vdb", "flux"), "") << "phi speaks for all of the solution";
    EXPECT_NE(solved.find("accuracy of multiple scattering: " + of_phi + "\n"), std::string::npos) << solved;
    EXPECT_EQ(stored("p.vdb", "transmittance_sun"), of_light) << "passed on";

    const std::string drawn =
        said({program("render"), scratch / "p.vdb", "--resolution", "8", "-o", scratch / "p.exr"});
    EXPECT_NE(drawn.find("accuracy of the light: phi: " + of_phi + "\n"), std::string::npos) << drawn;
    EXPECT_EQ(test::picture(scratch / "p.exr").text("vdbcloud:accuracy"), "phi: " + of_phi);
}

TEST_F(AccuracyOfResults, SayWhatALampLeavesOut)
{
    const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const std::string solved =
        said({program("p1solve"), input, "--extinction", "3", "--lamp", "0.1,0.2,0.3", "-o", scratch / "p.vdb"});
    EXPECT_NE(solved.find("; left out: " + std::string(lamp_cusp)), std::string::npos) << solved;
    EXPECT_EQ(stored("p.vdb", "transmittance_lamp"), "") << "rays are exact, and render takes rays near a lamp";
    const std::string drawn =
        said({program("render"), scratch / "p.vdb", "--resolution", "8", "-o", scratch / "p.exr"});
    EXPECT_NE(drawn.find("; left out: " + std::string(lamp_cusp)), std::string::npos) << drawn;
    EXPECT_EQ(said({program("render"), "-q", scratch / "p.vdb", "--resolution", "8", "-o", scratch / "p.exr"}), "");
}

/// The figures are those of the sum at the albedo asked for, not those of the albedo that was solved at.
TEST_F(AccuracyOfResults, OfASeriesAreThoseOfTheAlbedoAskedFor)
{
    const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME);
    stage("p1solve", input, "p.vdb",
          {"--extinction", "3", "--g", "0.5", "--sun", "0,1,0", "--albedo", "0.99", "--series", "2"});
    const std::string of_series = stored("p.vdb", "series_phi_0");
    EXPECT_EQ(of_series.rfind("series phi error ", 0), 0u) << of_series;
    const auto drawn = [&](const std::string& albedo) {
        return said(
            {program("render"), scratch / "p.vdb", "--albedo", albedo, "--resolution", "8", "-o", scratch / "p.exr"});
    };
    const std::string near = drawn("0.985"), far = drawn("0.9");
    for (const std::string& text : {near, far})
        EXPECT_NE(text.find("accuracy of the light: phi: residual "), std::string::npos) << text;
    EXPECT_EQ(near.find("the series errs by"), std::string::npos) << near;
    EXPECT_NE(far.find("the series errs by"), std::string::npos) << far;
}

}  // namespace
}  // namespace vdbcloud::test
