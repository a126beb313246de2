#pragma once
// A field of clumps that the programs' tests repeat, and programs that end as they should.
#include "apps/stages.h"
#include "support/fields.h"

namespace vdbcloud::test {

class RepeatingField : public Stages {
protected:
    /// Writes clumps over a thin layer without gaps, in voxels of edge `h`; returns the path.
    std::string field(const std::string& name, double h, const Vec3i& size = Vec3i(16, 8, 16))
    {
        const auto grid = box(size, h, [](openvdb::Coord c) { return c[1] == 0 ? 0.1 : clumps(c, 4, 1.0); });
        write_grid_file(scratch / name, file_of({grid}));
        return scratch / name;
    }
    RunResult ended(const std::string& name, const Words& words, int status)
    {
        const RunResult result = run(with({program(name)}, words));
        EXPECT_EQ(result.status, status) << name << " " << result.err;
        return result;
    }
    static void says(const RunResult& result, const std::string& text)
    {
        EXPECT_NE(result.err.find(text), std::string::npos) << result.err;
    }
};

}  // namespace vdbcloud::test
