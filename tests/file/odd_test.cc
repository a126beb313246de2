// The files of data/odd: each equals the output of make_odd, and each is used correctly or refused with a message.
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/compare.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"

#include "support/grids.h"
#include "support/make_odd.h"
#include "support/run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

std::string odd(const std::string& name) { return std::string(VDBCLOUD_ODD) + "/" + name; }

FloatGridPtr density(const std::string& name, std::string* warning = nullptr)
{
    auto file = read_grid_file(odd(name));
    return density_of(file, "", [&](const std::string& said) {
        if (warning) *warning += said;
    });
}

std::string objection(const std::string& name)
{
    const std::string said = sentence<InputError>([&] { density(name); });
    EXPECT_EQ(said.find(odd(name) + ": "), 0u) << said;
    return said.substr(std::min(said.size(), odd(name).size() + 2));
}

constexpr size_t ball_voxels = 895;  // of radius 6: lattice points with x^2 + y^2 + z^2 < 36

TEST(OddFiles, EqualTheOutputOfMakeOdd)
{
    const Scratch folder;
    make_odd_files(folder.path());
    std::set<std::string> made, kept;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) made.insert(entry.path().filename());
    for (const auto& entry : std::filesystem::directory_iterator(VDBCLOUD_ODD))
        if (entry.path().extension() == ".vdb") kept.insert(entry.path().filename());
    EXPECT_EQ(made, kept);
    for (const auto& name : made) {
        const auto difference = compare_files(read_grid_file(folder / name), read_grid_file(odd(name)));
        Tolerances none;
        none.metadata = true;
        const auto reasons = beyond(difference, none);
        EXPECT_TRUE(reasons.empty()) << name << ": " << reasons.front();
    }
}

TEST(OddFiles, KeepActiveTiles)
{
    const auto grid = density("tiles.vdb");
    EXPECT_EQ(grid->tree().activeTileCount(), 2u);
    EXPECT_EQ(grid->activeVoxelCount(), ball_voxels + 512 + 128 * 128 * 128);
    EXPECT_EQ(grid->tree().getValue(Coord(200, 100, 100)), 0.125f);
}

TEST(OddFiles, AcceptAffineTransformsAndRefuseFrustum)
{
    const auto grid = density("rotated.vdb");
    EXPECT_FALSE(grid->hasUniformVoxels());
    const Vec3d size = grid->voxelSize();
    EXPECT_NEAR(size[0], 0.5, 1e-12);
    EXPECT_NEAR(size[1], 0.25, 1e-12);
    EXPECT_NEAR(size[2], 0.75, 1e-12);
    EXPECT_EQ(objection("frustum.vdb"), "grid 'density' has a frustum (non-linear) transform: expected an affine one");
}

TEST(OddFiles, RequireAChoiceAmongGridsOfOneName)
{
    EXPECT_EQ(objection("three_of_one_name.vdb"), "3 grids are called 'density': expected a choice among 'density[0]', "
                                                  "'density[1]', 'density[2]'");
    auto file = read_grid_file(odd("three_of_one_name.vdb"));
    const auto last = density_of(file, "density[2]");
    EXPECT_EQ(last->indexToWorld(Coord(0)), Vec3d(6, 0, 0));
    EXPECT_EQ(last->activeVoxelCount(), ball_voxels);
    EXPECT_EQ(density_of(file, "density[0]")->treePtr(), last->treePtr()) << "stored once, held once";
    EXPECT_THROW(density_of(file, "density[3]"), InputError);
    EXPECT_THROW(density_of(file, "density"), InputError);
}

TEST(OddFiles, AcceptEmptyGridsAndRefuseFilesWithoutGrids)
{
    EXPECT_TRUE(density("empty.vdb")->empty());
    EXPECT_EQ(objection("no_grids.vdb"), "no density among its grids: it has no grids");
    const auto file = read_grid_file(odd("empty.vdb"));
    EXPECT_EQ(file.grids.size(), 4u);
    EXPECT_TRUE(has_meta(*file.metadata, "other/program/matrix"));
    EXPECT_EQ(grid_of(file, schema::velocity)->getName(), "velocity");
}

TEST(OddFiles, FindDensityUnderOddNamesAndTypes)
{
    EXPECT_EQ(density("unnamed.vdb")->activeVoxelCount(), ball_voxels);
    EXPECT_EQ(density("odd_name.vdb")->getName(), "voxel_fog_density");
    const auto from_double = density("double.vdb");
    EXPECT_EQ(from_double->getName(), "Density");
    EXPECT_EQ(from_double->tree().getValue(Coord(16)), 1.0f);
    EXPECT_NEAR(density("half.vdb")->tree().getValue(Coord(16, 17, 16)), 1 - 1 / 6.0, 5e-4);
    EXPECT_EQ(density("all_types.vdb")->activeVoxelCount(), ball_voxels);
}

TEST(OddFiles, RefuseLevelSetsPointsAndVectorsAsDensity)
{
    EXPECT_EQ(objection("level_set.vdb"), "grid 'ls_sphere' is a level set: expected a fog volume (vdb_tool -read "
                                          "in.vdb -ls2fog -write fog.vdb makes one)");
    EXPECT_EQ(objection("points.vdb"), "grid 'points' holds points: expected a fog volume (vdb_tool -read in.vdb "
                                       "-points2ls -ls2fog -write fog.vdb makes one)");
    auto file = read_grid_file(odd("all_types.vdb"));
    EXPECT_NE(sentence<InputError>([&] { density_of(file, "position"); }).find("type vec3d: expected float or double"),
              std::string::npos);
}

TEST(OddFiles, ClampNegativeValuesAndRefuseNaN)
{
    std::string warning;
    const auto grid = density("negative.vdb", &warning);
    EXPECT_EQ(warning, odd("negative.vdb") + ": grid 'density': 3 negative values taken as 0");
    EXPECT_EQ(grid->tree().getValue(Coord(30, 16, 16)), 0.0f);
    EXPECT_EQ(objection("nan.vdb").find("grid 'density': value nan at voxel [12, 16, 16]: expected finite"), 0u);
}

TEST(OddFiles, MergeThreeScalarsIntoAVector)
{
    const auto file = read_grid_file(odd("components.vdb"));
    const auto velocity = openvdb::gridPtrCast<Vec3SGrid>(grid_of(file, schema::velocity));
    ASSERT_TRUE(velocity);
    EXPECT_EQ(velocity->getName(), "vel");
    EXPECT_EQ(velocity->tree().getValue(Coord(16)), Vec3f(5, 2, 3));
    EXPECT_EQ(velocity->background(), Vec3f(1, 2, 3));
    EXPECT_EQ(velocity->activeVoxelCount(), 1u);
}

TEST(OddFiles, RoundTripUnchanged)
{
    const Scratch folder;
    for (const auto& entry : std::filesystem::directory_iterator(VDBCLOUD_ODD)) {
        if (entry.path().extension() != ".vdb") continue;
        const auto file = read_grid_file(entry.path());
        write_grid_file(folder / "copy.vdb", file);
        const auto copy = read_grid_file(folder / "copy.vdb");
        Tolerances none;
        none.metadata = true;
        const auto reasons = beyond(compare_files(file, copy), none);
        EXPECT_TRUE(reasons.empty()) << entry.path() << ": " << reasons.front();
        for (const auto& grid : copy.grids)
            EXPECT_FALSE(grid->metaValue<bool>(GridBase::META_IS_LOCAL_SPACE)) << entry.path();
    }
}

class Damaged : public testing::TestWithParam<std::string> {};

/// Files found by the fuzz test. data/odd/README.md describes the effect of each file on OpenVDB's reader.
TEST_P(Damaged, IsRefused)
{
    const std::string path = odd("damaged/" + GetParam());
    ASSERT_TRUE(std::filesystem::exists(path));
    const std::string said = sentence<IoError>([&] { read_grid_file(path); });
    EXPECT_EQ(said.find(path + ": malformed"), 0u) << said;
}

INSTANTIATE_TEST_SUITE_P(OddFiles, Damaged, testing::Values("heap.vdb", "memory.vdb", "string.vdb"),
                         [](const auto& test) { return test.param.substr(0, test.param.find('.')); });

}  // namespace
}  // namespace vdbcloud
