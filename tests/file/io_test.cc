// Writing and reading files: grids and metadata, half precision, choice and checks of the density.
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include "support/grids.h"
#include "support/run.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using test::file_of;
using test::Scratch;

/// The ball of support/grids.h and a separate active tile of 128^3 voxels.
FloatGridPtr ball(const std::string& name)
{
    const auto grid = test::ball(name);
    grid->tree().fill(CoordBBox(Coord(128, 0, 0), Coord(255, 127, 127)), 0.25f);
    return grid;
}

GridFile again(const GridFile& file, const WriteOptions& options = {})
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file, options);
    EXPECT_EQ(folder.list(), std::vector<std::string>{"a.vdb"});
    return read_grid_file(folder / "a.vdb");
}

TEST(GridIo, RoundTripKeepsValuesTopologyTransformAndMetadata)
{
    const auto grid = ball("density");
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(Vec3d(0.5, 1, 2));
    matrix.postRotate(openvdb::math::Z_AXIS, 0.4);
    matrix.postTranslate(Vec3d(3, -2, 7));
    grid->setTransform(Transform::createLinearTransform(matrix));
    set_vector(*grid, "vdbcloud:albedo", Vec3d(0.9, 0.8, 0.7));
    auto file = file_of({grid});
    set_text(*file.metadata, "history", "one\ntwo");
    set_number(*file.metadata, "meters_per_unit", 0.01);

    for (const auto compression : {Compression::Blosc, Compression::Zip, Compression::None}) {
        WriteOptions options;
        options.compression = compression;
        auto back = again(file, options);
        ASSERT_EQ(back.grids.size(), 1u);
        const auto density = density_of(back);
        EXPECT_EQ(density->background(), 0.0f);
        EXPECT_EQ(density->activeVoxelCount(), grid->activeVoxelCount());
        EXPECT_EQ(density->tree().activeTileCount(), grid->tree().activeTileCount());
        EXPECT_GT(grid->tree().activeTileCount(), 0u);
        for (auto it = grid->cbeginValueOn(); it; ++it)
            ASSERT_EQ(density->tree().getValue(it.getCoord()), *it) << it.getCoord();
        EXPECT_EQ(density->transform(), grid->transform());
        EXPECT_EQ(density->getGridClass(), openvdb::GRID_FOG_VOLUME);
        EXPECT_EQ(get_vector(*density, "vdbcloud:albedo", Vec3d(0)), Vec3d(0.9, 0.8, 0.7));
        EXPECT_EQ(get_text(*back.metadata, "history", ""), "one\ntwo");
        EXPECT_EQ(get_number(*back.metadata, "meters_per_unit", 0), 0.01);
        EXPECT_EQ(grid_digest(*density), grid_digest(*grid));
    }
}

TEST(GridIo, StatisticsOfAnotherTypeAreReplaced)
{
    // OpenVDB's writer has values of its own for these names, and throws at one of another type.
    using openvdb::GridBase;
    for (const char* key : {GridBase::META_FILE_COMPRESSION, GridBase::META_FILE_BBOX_MIN, GridBase::META_FILE_BBOX_MAX,
                            GridBase::META_FILE_MEM_BYTES, GridBase::META_FILE_VOXEL_COUNT}) {
        const auto grid = ball("density");
        grid->insertMeta(key, openvdb::FloatMetadata(1));
        const auto back = again(file_of({grid}));
        ASSERT_TRUE((*back.grids.at(0))[key]) << key;
        EXPECT_NE((*back.grids.at(0))[key]->typeName(), "float") << key;
    }
}

TEST(GridIo, EqualGridsGiveEqualBytes)
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file_of({ball("density")}));
    write_grid_file(folder / "b.vdb", file_of({ball("density")}));
    EXPECT_EQ(test::read_text(folder / "a.vdb"), test::read_text(folder / "b.vdb"));
    auto other = ball("density");
    other->tree().setValue(Coord(1, 2, 3), 0.5f);
    write_grid_file(folder / "b.vdb", file_of({other}));
    const std::string a = test::read_text(folder / "a.vdb"), b = test::read_text(folder / "b.vdb");
    EXPECT_NE(a.substr(21, 36), b.substr(21, 36));
    EXPECT_EQ(a[29], '-');
}

TEST(GridIo, HalfRoundsDensityColourAndMomentsAndUpdatesDensityDigests)
{
    const auto density = ball("density"), light = ball("transmittance_sun"), phi = ball("temperature");
    const auto colour = Vec3SGrid::create(Vec3f(1));
    colour->setName("Cd");
    set_text(*light, "vdbcloud:density_digest", grid_digest(*density));
    light->setSaveFloatAsHalf(true);  // as if copied from the density's metadata
    WriteOptions options;
    options.half = true;
    const auto moment = ball("sh_2m1_r"), fluence = ball("phi");
    set_text(*moment, "vdbcloud:density_digest", grid_digest(*density));
    auto back = again(file_of({density, light, phi, colour, moment, fluence}), options);
    EXPECT_TRUE(back.grids[0]->saveFloatAsHalf());
    EXPECT_FALSE(back.grids[1]->saveFloatAsHalf());
    EXPECT_FALSE(back.grids[2]->saveFloatAsHalf());
    EXPECT_TRUE(back.grids[3]->saveFloatAsHalf());
    EXPECT_TRUE(back.grids[4]->saveFloatAsHalf());
    EXPECT_FALSE(back.grids[5]->saveFloatAsHalf());
    EXPECT_EQ(get_text(*back.grids[4], "vdbcloud:density_digest", ""), grid_digest(*density_of(back)));
    EXPECT_EQ(grid_digest(static_cast<FloatGrid&>(*back.grids[1])), grid_digest(*light));
    const std::string rounded = grid_digest(*density_of(back));
    EXPECT_NE(rounded, grid_digest(*density));
    EXPECT_EQ(get_text(*back.grids[1], "vdbcloud:density_digest", ""), rounded);
    EXPECT_EQ(get_text(*light, "vdbcloud:density_digest", ""), grid_digest(*density)) << "in memory nothing changed";
    auto once_more = again(back);
    EXPECT_EQ(grid_digest(*density_of(once_more)), rounded) << "half stays half when it is passed on";

    const auto dense = FloatGrid::create(70000.0f);
    dense->setName("density");
    EXPECT_THROW(again(file_of({dense}), options), InputError);
}

TEST(GridIo, AFaintGridKeepsItsFloatsWithAWarning)
{
    // Cloud water in kg/kg, largest value `scale`: halves below 6.1e-5 are 6e-8 apart. Of a ball whose density falls
    // linearly, a share of 1 - (1 - v)^3 lies below v times the maximum: 6 % at 3e-3, 49 % at 3e-4.
    for (const auto& [scale, half] : {std::pair(1.0f, true), {3e-3f, true}, {3e-4f, false}, {1e-6f, false}}) {
        const auto water = test::ball("density", 14);
        for (auto v = water->beginValueOn(); v; ++v) v.setValue(*v * scale);
        std::vector<std::string> said;
        WriteOptions options;
        options.half = true;
        options.warn = [&](const std::string& s) { said.push_back(s); };
        auto back = again(file_of({water}), options);
        EXPECT_EQ(back.grids[0]->saveFloatAsHalf(), half) << scale;
        ASSERT_EQ(said.size(), half ? 0u : 1u) << scale;
        if (!half) {
            EXPECT_NE(said[0].find("'density'"), std::string::npos) << said[0];
            EXPECT_EQ(grid_digest(*density_of(back)), grid_digest(*water)) << "stored exactly";
        }
    }
    // Values that are halves already lose nothing.
    const auto exact = FloatGrid::create(0.0f);
    exact->setName("density");
    exact->fill(openvdb::CoordBBox::createCube({0, 0, 0}, 4), 0x3p-24f);
    WriteOptions options;
    options.half = true;
    auto back = again(file_of({exact}), options);
    EXPECT_TRUE(back.grids[0]->saveFloatAsHalf());
    EXPECT_EQ(density_of(back)->tree().getValue(Coord(1, 1, 1)), 0x3p-24f);
}

TEST(GridIo, FindsDensityByAliasOrAsTheOnlyFog)
{
    auto file = file_of({ball("temperature"), ball("smoke")});
    EXPECT_EQ(density_of(file)->getName(), "smoke");
    file = file_of({ball("temperature"), ball("lorenz")});
    EXPECT_EQ(density_of(file)->getName(), "lorenz");
    EXPECT_EQ(density_of(file, "temperature")->getName(), "temperature");
    EXPECT_THROW(density_of(file, "nothing"), InputError);
    file = file_of({ball("a"), ball("b")});
    EXPECT_THROW(density_of(file), InputError);
    file = file_of({ball("density"), ball("density")});
    EXPECT_THROW(density_of(file), InputError);
    EXPECT_EQ(density_of(file, "density[1]"), file.grids[1]);
}

TEST(GridIo, ClampsNegativeValuesWithOneWarningAndRefusesNaN)
{
    auto grid = ball("density");
    grid->tree().setValue(Coord(0, 0, 0), -1.0f);
    grid->tree().setValue(Coord(50, 0, 0), -2.0f);
    auto file = file_of({grid});
    std::vector<std::string> said;
    const auto density = density_of(file, "", [&](const std::string& s) { said.push_back(s); });
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("2 negative values"), std::string::npos) << said[0];
    EXPECT_EQ(density->tree().getValue(Coord(50, 0, 0)), 0.0f);
    EXPECT_EQ(grid->tree().getValue(Coord(50, 0, 0)), -2.0f) << "the original is not to change";
    EXPECT_EQ(file.grids[0], density);

    grid->tree().setValue(Coord(3, 4, 5), NAN);
    file = file_of({grid});
    try {
        density_of(file);
        FAIL() << "NaN went through";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("[3, 4, 5]"), std::string::npos) << e.what();
    }
}

TEST(GridIo, ValuesOfInactiveVoxelsThatAreNotFiniteBecomeTheBackground)
{
    const auto grid = ball("density");
    const float infinity = std::numeric_limits<float>::infinity();
    grid->tree().setValueOff(Coord(8, 8, 8), NAN);
    grid->tree().setValueOff(Coord(9, 8, 8), infinity);
    grid->tree().setValueOff(Coord(8, 9, 8), -infinity);
    grid->tree().addTile(1, Coord(64, 0, 0), NAN, /*active=*/false);
    auto file = file_of({grid});
    std::vector<std::string> said;
    const auto density = density_of(file, "", [&](const std::string& s) { said.push_back(s); });
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("4 values of inactive voxels not finite"), std::string::npos) << said[0];
    for (const Coord& at : {Coord(8, 8, 8), Coord(9, 8, 8), Coord(8, 9, 8), Coord(66, 3, 3)})
        EXPECT_EQ(density->tree().getValue(at), 0.0f) << at;
    EXPECT_EQ(density->activeVoxelCount(), grid->activeVoxelCount());
    EXPECT_EQ(density->tree().getValue(Coord(0, 0, 0)), 1.0f);
    // Where a voxel or a tile is active, or the background itself is not finite, the density has no meaning.
    for (const int wrong : {0, 1, 2}) {
        const auto bad = wrong == 2 ? FloatGrid::create(NAN) : test::ball("density");
        bad->setName("density");
        if (wrong == 0) bad->tree().setValueOn(Coord(1, 2, 3), infinity);
        if (wrong == 1) bad->tree().addTile(1, Coord(64, 0, 0), NAN, /*active=*/true);
        auto refused = file_of({bad});
        EXPECT_THROW(density_of(refused), InputError) << wrong;
    }
}

}  // namespace
}  // namespace vdbcloud
