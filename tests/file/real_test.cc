// Files of other programs (VDBCLOUD_REAL=folder): all are read and written without loss, and their density is found or
// refused with a message.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"

#include "support/run.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace vdbcloud {
namespace {

/// Expected result of density_of() for each file: part of the error message; empty if the file has a usable density.
const std::map<std::string, std::string> expected = {
    {"wdas_cloud_sixteenth.vdb", ""},
    {"openvdb_smoke.vdb", ""},
    {"fire_density_heat.vdb", ""},
    {"blender_smoke_000002.vdb", ""},
    {"blender_smoke_000001_empty.vdb", ""},
    {"dragon_fog_with_xform.vdb", ""},
    {"three_grids_named_density.vdb", "density[2]"},
    {"torus_odd_grid_name.vdb", ""},
    {"levelset_sphere.vdb", "level set"},
    {"points.vdb", "points"},
};

class RealFile : public testing::TestWithParam<std::string> {};

TEST_P(RealFile, RoundTripsAndHasADensityOrIsRefused)
{
    const char* folder = std::getenv("VDBCLOUD_REAL");
    if (!folder) GTEST_SKIP() << "VDBCLOUD_REAL is not set";
    const std::string path = std::string(folder) + "/" + GetParam();
    auto file = read_grid_file(path);
    ASSERT_FALSE(file.grids.empty());

    const test::Scratch scratch;
    write_grid_file(scratch / "copy.vdb", file);
    const auto copy = read_grid_file(scratch / "copy.vdb");
    ASSERT_EQ(copy.grids.size(), file.grids.size());
    for (size_t k = 0; k < copy.grids.size(); ++k) {
        EXPECT_EQ(copy.grids[k]->getName(), file.grids[k]->getName());
        EXPECT_EQ(copy.grids[k]->type(), file.grids[k]->type());
        EXPECT_EQ(copy.grids[k]->transform(), file.grids[k]->transform());
        EXPECT_EQ(copy.grids[k]->activeVoxelCount(), file.grids[k]->activeVoxelCount());
        const auto a = openvdb::gridPtrCast<FloatGrid>(copy.grids[k]),
                   b = openvdb::gridPtrCast<FloatGrid>(file.grids[k]);
        if (a && b) {
            EXPECT_EQ(grid_digest(*a), grid_digest(*b));
        }
    }

    const std::string& part = expected.at(GetParam());
    if (part.empty()) {
        EXPECT_NO_THROW(density_of(file));
        return;
    }
    try {
        density_of(file);
        FAIL() << "accepted";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
        EXPECT_EQ(std::string(e.what()).find(path), 0u) << e.what();
    }
}

std::vector<std::string> names()
{
    std::vector<std::string> all;
    for (const auto& entry : expected) all.push_back(entry.first);
    return all;
}

INSTANTIATE_TEST_SUITE_P(Real, RealFile, testing::ValuesIn(names()),
                         [](const auto& test) { return test.param.substr(0, test.param.find('.')); });

}  // namespace
}  // namespace vdbcloud
