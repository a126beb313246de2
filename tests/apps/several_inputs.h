#pragma once
// Files with a body each, commands on several of them, and what comes out.
#include "support/moved.h"
#include "support/picture_file.h"
#include "support/run.h"

#include "support/fields.h"
#include "support/grids.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace vdbcloud::test {

using openvdb::Coord;
using Words = std::vector<std::string>;

inline constexpr double edge = 0.1;  // of a voxel [world unit]

/// A clumpy body of 16 x n x 16 voxels.
inline FloatGridPtr body(uint64_t seed, int n = 16)
{
    return box({16, n, 16}, edge, [&](Coord ijk) { return 0.1 + clumps(ijk, seed, 1.0); });
}

class SeveralInputs : public testing::Test {
protected:
    std::string path(const std::string& name) const { return scratch / name; }

    void write(const std::string& name, const FloatGridPtr& density, double sigma_t = 6, double albedo = 0.9,
               double g = 0, const std::map<std::string, std::string>& metadata = {},
               std::vector<GridBasePtr> more = {})
    {
        const auto grid = density->deepCopy();
        Medium m;
        m.sigma_t_per_density = Vec3d(sigma_t);
        m.albedo = Vec3d(albedo);
        m.phase = PhaseFunction::henyey_greenstein(g);
        write_medium(*grid, m);
        more.insert(more.begin(), grid);
        GridFile file = file_of(more);
        for (const auto& [key, value] : metadata) set_text(*file.metadata, key, value);
        write_grid_file(path(name), file);
    }

    /// Runs in the folder of the files.
    RunResult run_line(const std::string& program_name, const std::string& arguments)
    {
        RunOptions there;
        there.folder = scratch.path();
        return shell(program_name + " " + arguments, there);
    }
    std::string done(const std::string& program_name, const std::string& arguments)
    {
        const RunResult result = run_line(program_name, arguments);
        EXPECT_EQ(result.status, 0) << program_name << " " << arguments << "\n" << result.err;
        return result.err;
    }
    /// The sentence of a command that is refused with status 2.
    std::string refused(const std::string& program_name, const std::string& arguments)
    {
        const RunResult result = run_line(program_name, arguments);
        EXPECT_EQ(result.status, 2) << program_name << " " << arguments << "\n" << result.err;
        return result.err;
    }
    bool equal(const std::string& a, const std::string& b)
    {
        const RunResult result = run({program("vdbdiff"), path(a), path(b)});
        EXPECT_LE(result.status, 3) << result.err;
        return result.status == 0;
    }

    /// A picture of `inputs`, from the side, of the 1.6 x 1.6 world units at the origin.
    PictureFile view(const std::string& inputs, const std::string& options)
    {
        done("render", "-q " + inputs +
                           " --projection orthographic --camera 0.8,0.8,20 --look-at 0.8,0.8,0 --ortho-width 1.6 "
                           "--resolution 24 -o picture.exr " +
                           options);
        return picture(path("picture.exr"));
    }
    static double mean(const PictureFile& seen, const std::string& layer = "R")
    {
        double sum = 0;
        for (const float value : seen.layer(layer)) sum += value / (24.0 * 24);
        return sum;
    }
    double mean(const std::string& inputs, const std::string& options, const std::string& layer = "R")
    {
        return mean(view(inputs, options), layer);
    }

    Scratch scratch;
};

}  // namespace vdbcloud::test
