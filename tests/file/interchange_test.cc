// OpenVDB's programs read vdbcloud's files, and vdbcloud reads files of OpenVDB's programs.
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/compare.h"
#include "vdbcloud/grid/metadata.h"

#include "support/grids.h"
#include "support/redirect.h"
#include "support/run.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using namespace test;

bool there(const std::string& tool) { return shell("command -v " + tool).status == 0; }

/// Two files with the same grids: one in the layout for files, one in the layout for pipes.
class Interchange : public testing::Test {
protected:
    void SetUp() override
    {
        const auto velocity = Vec3SGrid::create(Vec3f(0));
        velocity->setName("vel");
        velocity->tree().setValue(openvdb::Coord(1, 2, 3), Vec3f(1, 2, 3));
        const auto light = ball("transmittance_sun");
        light->tree().root().setBackground(1.0f, true);
        file_ = file_of({ball("density"), velocity, light, FloatGrid::create()});
        set_text(*file_.metadata, "history", "fractalgen 0.1.0 seed=7");
        write_grid_file(folder_ / "file.vdb", file_);
        write_text(folder_ / "stream.vdb", output_of([&] { write_grid_file("-", file_); }));
    }

    GridFile file_;
    Scratch folder_;
};

TEST_F(Interchange, VdbPrintListsOurFilesWithoutWarning)
{
    if (!there("vdb_print")) GTEST_SKIP() << "vdb_print is not installed";
    for (const char* name : {"file.vdb", "stream.vdb"}) {
        const auto listed = run({"vdb_print", "-l", folder_ / name});  // vdb_print always exits with status 0
        for (const char* complaint : {"ERROR", "FATAL", "WARN"}) {
            EXPECT_EQ(listed.out.find(complaint), std::string::npos) << listed.out;
            EXPECT_EQ(listed.err.find(complaint), std::string::npos) << listed.err;
        }
        for (const char* part :
             {"transmittance_sun", "vel", "Name: density", "fractalgen 0.1.0", "is_local_space: false"})
            EXPECT_NE(listed.out.find(part), std::string::npos) << part << "\n" << listed.out;
    }
}

TEST_F(Interchange, VdbToolCopiesOurFilesUnchanged)
{
    if (!there("vdb_tool")) GTEST_SKIP() << "vdb_tool is not installed";
    const std::string back = folder_ / "back.vdb";
    for (const char* name : {"file.vdb", "stream.vdb"}) {
        const auto result = run({"vdb_tool", "-read", folder_ / name, "-write", back});
        ASSERT_EQ(result.status, 0) << result.err << result.out;
        const auto reasons =
            beyond(compare_files(file_, read_grid_file(back), {"density", "vel", "transmittance_sun"}), {});
        EXPECT_TRUE(reasons.empty()) << reasons.front();
    }
}

}  // namespace
}  // namespace vdbcloud
