// Pictures of several files against light paths through all of them.
#include "support/fields.h"
#include "support/grids.h"
#include "support/moved.h"
#include "support/picture_file.h"
#include "support/run.h"
#include "support/size.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/optics/medium.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace vdbcloud::test {
namespace {

constexpr double edge = 1.0 / 12;  // of a voxel [world unit]

/// Means of the four quarters of a picture. Paths: the standard errors of all light, which those of a part do not
/// exceed.
struct Quarters {
    std::array<double, 4> mean{}, error{};
};

constexpr int pixels = 32;  // along each side of a picture
const char* const lights = " --sun 0.3,1,0.2 --lamp 2.6,1.2,2.4 --lamp-intensity 4";

class SeveralFiles : public testing::Test {
protected:
    /// A smooth body of 20^3 voxels with a bright and a dark side, of about four mean free paths.
    void write(const std::string& name, const Vec3d& at, double sigma_t, double albedo, double g, double lean)
    {
        auto grid = moved(box({20, 20, 20}, edge,
                              [&](openvdb::Coord ijk) {
                                  const Vec3d x = Vec3d(ijk[0], ijk[1], ijk[2]) - Vec3d(9.5);
                                  const double r = x.length() / 10;
                                  return r < 1 ? (1 - r * r) * (1 + lean * x[0] / 10) : 0.0;
                              }),
                          at);
        Medium m;
        m.sigma_t_per_density = Vec3d(sigma_t);
        m.albedo = Vec3d(albedo);
        m.phase = PhaseFunction::henyey_greenstein(g);
        write_medium(*grid, m);
        write_grid_file(scratch / name, file_of({grid}));
    }

    void done(const std::string& name, const std::string& arguments)
    {
        RunOptions options;
        options.seconds = 600;
        options.folder = scratch.path();
        const RunResult result = shell(name + " -q " + arguments, options);
        EXPECT_EQ(result.status, 0) << name << " " << arguments << "\n" << result.err;
    }

    /// Of a picture from the side, obliquely: body a is in the lower half, body b in the upper one.
    PictureFile view(const std::string& inputs, const std::string& options)
    {
        done("render", inputs +
                           " --projection orthographic --camera 6,1.9,20 --look-at 1.0,1.5,0.9 --ortho-width 4.6 "
                           "--resolution " +
                           std::to_string(pixels) + " --aov direct -o picture.exr " + options);
        return picture(scratch / "picture.exr");
    }

    /// By light paths, in two pictures of different samples, whose difference is the error.
    std::array<PictureFile, 2> traced(const std::string& inputs)
    {
        const int spp = sized(16, 500);
        const auto half = [&](int from) {
            return view(inputs, "--integrator path --spp " + std::to_string(spp) + " --spp-offset " +
                                    std::to_string(from) + lights);
        };
        return {half(0), half(spp)};
    }

    static Quarters in_quarters(const PictureFile& one, const std::vector<std::string>& layers)
    {
        return in_quarters(one, one, layers);
    }

    /// The sum of layers, in the mean of two pictures.
    static Quarters in_quarters(const PictureFile& first, const PictureFile& second,
                                const std::vector<std::string>& layers)
    {
        const auto at = [&](const PictureFile& file, int i, int j) {
            double sum = 0;
            for (const std::string& layer : layers) sum += double(file.at(i, j, layer));
            return sum;
        };
        constexpr double share = 4.0 / (pixels * pixels);
        Quarters out;
        for (int i = 0; i < pixels; ++i)
            for (int j = 0; j < pixels; ++j) {
                const size_t q = size_t(i / (pixels / 2) + 2 * (j / (pixels / 2)));
                const double a = at(first, i, j), b = at(second, i, j);
                out.mean[q] += share * (a + b) / 2;
                out.error[q] += std::pow(share * (a - b) / 2, 2);
            }
        for (double& e : out.error) e = std::sqrt(e);
        return out;
    }

    Scratch scratch;
};

/// `found` is `paths` within 4.5 standard errors and `share` of the value, and paths say enough.
void expect_near(const Quarters& found, const Quarters& paths, double share, const std::string& what)
{
    for (size_t q = 0; q < 4; ++q) {
        EXPECT_NEAR(found.mean[q], paths.mean[q], 4.5 * paths.error[q] + share * paths.mean[q]) << what << ' ' << q;
        EXPECT_LT(paths.error[q], 0.06 * paths.mean[q]) << what << " says little " << q;
    }
}

const Vec3d overlapping(6 * edge, 9 * edge, 3 * edge), apart(3 * edge, 24 * edge, 2 * edge);

const std::vector<std::string> all{"R"}, once{"direct_sun.R", "direct_lamp.R"};

TEST_F(SeveralFiles, SolvedTogetherAreWhatPathsSee)
{
    // 0.5 mean free paths a voxel. Where the bodies overlap, their albedos of 0.98 and 0.7 become a Cd, of which the
    // product with density is not the sum of both products between the voxels' centres. Degree 1 errs by up to 3 % at
    // g 0.5, degree 3 by 2 %.
    for (const Vec3d& shift : {overlapping, apart}) {
        write("a.vdb", Vec3d(0), 6, 0.98, 0.5, 0.6);
        write("b.vdb", shift, 4, 0.7, 0.5, -0.5);
        const auto [first, second] = traced("a.vdb b.vdb");
        done("p1solve", std::string("a.vdb b.vdb -o solved.vdb --iterations 6 ") +
                            sized("--directions 32 --degree 1", "--directions 64 --degree 3") + lights);
        expect_near(in_quarters(view("solved.vdb", "--samples 2"), all), in_quarters(first, second, all),
                    sized(0.03, 0.02), "all light");
        done("illuminate", std::string("a.vdb b.vdb -o lit.vdb") + lights);
        // Light scattered once: transmittance between voxels errs by 2 %.
        expect_near(in_quarters(view("lit.vdb", "--samples 2"), once), in_quarters(first, second, once), 0.02,
                    "light scattered once");
    }
}

TEST_F(SeveralFiles, OfUnequalPhaseScatterOnceAsPathsSay)
{
    // illuminate and p1solve take one phase function for all; render keeps that of each file.
    write("a.vdb", Vec3d(0), 6, 0.98, 0.6, 0.6);
    write("b.vdb", overlapping, 4, 0.7, -0.4, -0.5);
    const Quarters both = in_quarters(view("a.vdb b.vdb", std::string("--samples 2") + lights), once);
    const auto [first, second] = traced("a.vdb b.vdb");
    expect_near(both, in_quarters(first, second, once), 0.02, "of both");
    write("b.vdb", overlapping, 4, 0.7, 0.6, -0.5);
    const Quarters equal = in_quarters(view("a.vdb b.vdb", std::string("--samples 2") + lights), once);
    EXPECT_GT(std::abs(equal.mean[2] / both.mean[2] - 1), 0.2) << "the phase function matters";
}

}  // namespace
}  // namespace vdbcloud::test
