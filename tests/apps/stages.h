#pragma once
// Chains of programs as a user builds them: files in, files and pictures out.
#include "support/grids.h"
#include "support/picture_file.h"
#include "support/run.h"
#include "vdbcloud/file/io.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdbcloud::test {

using Words = std::vector<std::string>;

class Stages : public testing::Test {
protected:
    /// A ball of density under a name, of a class; then other grids.
    std::string write_ball(const std::string& file_name, const std::string& grid_name, openvdb::GridClass grid_class,
                           std::vector<GridBasePtr> others = {})
    {
        const auto grid = ball(grid_name, 5);
        grid->setGridClass(grid_class);
        others.insert(others.begin(), grid);
        write_grid_file(scratch / file_name, file_of(others));
        return scratch / file_name;
    }
    std::string unknown() { return write_ball("blob.vdb", "blob", openvdb::GRID_UNKNOWN); }

    /// Runs PROGRAM INPUT -o OUTPUT OPTIONS, which must end well; returns the output's path.
    std::string stage(const std::string& name, const std::string& input, const std::string& output, Words options)
    {
        Words words{program(name)};
        if (!input.empty()) words.push_back(input);
        words.insert(words.end(), {"-o", scratch / output});
        words.insert(words.end(), options.begin(), options.end());
        const RunResult result = run(words);
        EXPECT_EQ(result.status, 0) << name << " " << output << ": " << result.err;
        return scratch / output;
    }

    std::vector<float> picture(const std::string& input, Words options)
    {
        options.insert(options.end(), {"--resolution", "8"});
        return test::picture(stage("render", input, "picture.exr", options)).pixels;
    }

    static Words names(const std::string& path)
    {
        Words all;
        for (const GridBasePtr& grid : read_grid_file(path).grids) all.push_back(grid->getName());
        return all;
    }

    Scratch scratch;
};

inline const Words medium{"--albedo", "0.9", "--g", "0.5", "--extinction", "3", "--sun", "0,1,0"};

inline Words with(Words a, const Words& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

}  // namespace vdbcloud::test
