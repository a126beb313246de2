// Grids from NanoVDB, and to netCDF and USD.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/export_netcdf.h"
#include "vdbcloud/exchange/nanovdb_file.h"
#include "vdbcloud/exchange/netcdf_file.h"
#include "vdbcloud/exchange/usd.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"

#include "support/damage.h"
#include "support/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbcloud::test {
namespace {

std::string refusal(const std::string& path)
{
    try {
        read_nanovdb(path);
    } catch (const std::exception& e) {
        return e.what();
    }
    return "read";
}

/// density, vel and phi on 5 x 4 x 3 voxels of 0.5 x 0.25 x 1 about (3, 2, 1), and a tile far away in phi; with
/// metadata.
GridFile small_file(UpAxis up)
{
    openvdb::initialize();
    const auto transform = Transform::createLinearTransform(1);
    transform->preScale(Vec3d(0.5, 0.25, 1));
    transform->postTranslate(Vec3d(3, 2, 1));
    const auto density = FloatGrid::create(0.0f);
    const auto velocity = Vec3SGrid::create(Vec3f(0));
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 3; ++k) {
                density->tree().setValue({i, j, k}, float(1 + i + 10 * j + 100 * k));
                velocity->tree().setValue({i, j, k}, Vec3f(float(i), float(j), float(k)));
            }
    density->setName(schema::density);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    velocity->setName(schema::velocity);
    density->setTransform(transform);
    velocity->setTransform(transform->copy());
    set_vector(*density, schema::sigma_t_per_density, Vec3d(2.0));
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {density, velocity};
    write_up_axis(*file.metadata, up);
    set_number(*file.metadata, schema::meters_per_unit, 10);
    return file;
}

TEST(NanoVdb, GridsAreThoseOfTheFile)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    GridFile file = small_file(UpAxis::Y);
    std::dynamic_pointer_cast<FloatGrid>(file.grids[0])->tree().addTile(1, {64, 0, -8}, 0.5f, true);
    std::dynamic_pointer_cast<FloatGrid>(file.grids[0])->tree().addTile(2, {-256, 128, 0}, 0.25f, true);
    write_grid_file(scratch / "a.vdb", file);
    for (const char* packed : {"", "-z", "-b"}) {
        const RunResult r = shell(std::string("nanovdb_convert -f ") + packed +
                                      " a.vdb a.nvdb && vdbimport a.nvdb --up z --meters-per-unit 10 -o b.vdb && "
                                      "vdbdiff a.vdb b.vdb",
                                  there);
        EXPECT_EQ(r.status, 0) << packed << r.err;
    }
    const GridFile back = read_grid_file(scratch / "b.vdb");
    EXPECT_EQ(back.grids.size(), 2u);
    EXPECT_EQ(back.grids[0]->getGridClass(), openvdb::GRID_FOG_VOLUME);
    EXPECT_EQ(get_text(*back.metadata, schema::up_axis, ""), "Z");
    EXPECT_EQ(get_number(*back.metadata, schema::meters_per_unit, 0), 10);
    // Eight bits between the least and the largest value of a block.
    const RunResult coarse = shell(
        "nanovdb_convert -f --fp8 a.vdb a.nvdb && vdbimport a.nvdb -o b.vdb && vdbdiff a.vdb b.vdb --max 0.5", there);
    EXPECT_EQ(coarse.status, 0) << coarse.err;
    EXPECT_EQ(shell("vdbimport a.nvdb --cell 1,1,1 -o b.vdb", there).status, 2);

    const std::string whole = read_text(scratch / "a.nvdb");
    int refused = 0;
    for (uint64_t seed = 0; seed < 60; ++seed) {
        Dice dice(seed);
        write_text(scratch / "damaged.nvdb", damaged(whole, dice));
        const std::string said = refusal(scratch / "damaged.nvdb");
        if (said == "read") continue;
        ++refused;
        EXPECT_EQ(said.rfind(scratch / "damaged.nvdb", 0), 0u) << said;
    }
    EXPECT_GT(refused, 10);
    write_text(scratch / "short.nvdb", whole.substr(0, whole.size() / 2));
    EXPECT_NE(refusal(scratch / "short.nvdb"), "read");
}

TEST(ExportNetcdf, CoordinatesUnitsAndValuesOfEitherUpAxis)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    for (const UpAxis up : {UpAxis::Z, UpAxis::Y}) {
        write_grid_file(scratch / "a.vdb", small_file(up));
        const RunResult r =
            shell("vdbexport a.vdb -o a.nc && cp a.nc b.nc && vdbexport a.vdb -o a.nc && cmp a.nc b.nc", there);
        ASSERT_EQ(r.status, 0) << r.err;
        const NetcdfFile file(scratch / "a.nc");
        const auto *x = file.variable("x"), *y = file.variable("y"), *z = file.variable("z"),
                   *density = file.variable("density"), *extinction = file.variable("extinction"),
                   *vel = file.variable("vel");
        ASSERT_TRUE(x && y && z && density && extinction && vel);
        EXPECT_EQ(x->attribute("units"), "m");
        EXPECT_EQ(z->attribute("positive"), "up");
        EXPECT_EQ(extinction->attribute("units"), "m-1");
        EXPECT_EQ(vel->attribute("units"), "m s-1");
        EXPECT_EQ(vel->dimensions.size(), 4u);
        // World x, -z, y are x, y, z where y is up.
        const bool turned = up == UpAxis::Y;
        const size_t ny = turned ? 3 : 4, nz = turned ? 4 : 3;
        const auto xs = file.doubles(*x), ys = file.doubles(*y), zs = file.doubles(*z);
        ASSERT_EQ(xs.size(), 5u);
        ASSERT_EQ(ys.size(), ny);
        ASSERT_EQ(zs.size(), nz);
        EXPECT_NEAR(xs[1], 35, 1e-9);
        EXPECT_NEAR(ys[0], turned ? -30 : 20, 1e-9);
        EXPECT_NEAR(ys[1], turned ? -20 : 22.5, 1e-9);
        EXPECT_NEAR(zs[1], turned ? 22.5 : 20, 1e-9);
        const auto values = file.floats(*density, {0, 0, 0}, {nz, ny, 5});
        const auto thick = file.floats(*extinction, {0, 0, 0}, {nz, ny, 5});
        for (size_t c = 0; c < 3; ++c) {
            const auto speed = file.floats(*vel, {c, 0, 0, 0}, {1, nz, ny, 5});
            for (size_t k = 0; k < nz; ++k)
                for (size_t j = 0; j < ny; ++j)
                    for (size_t i = 0; i < 5; ++i) {
                        const size_t at = i + 5 * (j + ny * k), wy = turned ? k : j, wz = turned ? 2 - j : k;
                        const auto expected = float(1 + i + 10 * wy + 100 * wz);
                        ASSERT_EQ(values[at], expected);
                        ASSERT_NEAR(thick[at], 2 * expected / 10, 1e-5 * double(expected));
                        const double world[3] = {10.0 * double(i), 10.0 * double(wy), 10.0 * double(wz)};
                        const double along[3] = {world[0], turned ? -world[2] : world[1], turned ? world[1] : world[2]};
                        ASSERT_EQ(double(speed[at]), along[c]) << c;
                    }
        }
    }
}

TEST(ExportNetcdf, CoordinatesRiseWhereVoxelsFallAndChannelsKeepTheirUnits)
{
    const Scratch scratch;
    for (const UpAxis up : {UpAxis::Z, UpAxis::Y}) {
        GridFile file = small_file(up);
        const auto transform = Transform::createLinearTransform(1);
        transform->preScale(Vec3d(-0.5, -0.25, 1));
        const auto emission = Vec3SGrid::create(Vec3f(0));
        emission->setName(schema::emission);
        emission->tree().setValue({4, 3, 2}, Vec3f(5, 6, 7));
        file.grids[1] = emission;
        const auto heat = FloatGrid::create(0.0f);
        heat->setName(schema::temperature);
        heat->tree().setValue({4, 3, 2}, 0.5f);
        set_number(*heat, schema::kelvin_scale, 3000);
        set_number(*heat, schema::kelvin_offset, 290);
        file.grids.push_back(heat);
        for (const GridBasePtr& grid : file.grids) grid->setTransform(transform->copy());
        set_vector(*file.grids[0], schema::sigma_t_per_density, Vec3d(2, 3, 4));
        write_netcdf(scratch / "a.nc", file, "", false);
        const NetcdfFile read(scratch / "a.nc");
        std::array<std::vector<double>, 3> at;
        for (const size_t a : {0, 1, 2}) {
            at[a] = read.doubles(*read.variable(std::string(1, "xyz"[a])));
            for (size_t k = 1; k < at[a].size(); ++k) EXPECT_GT(at[a][k], at[a][k - 1]) << a;
        }
        const size_t nx = at[0].size(), ny = at[1].size(), nz = at[2].size();
        const auto *thick = read.variable("extinction"), *hot = read.variable(schema::emission);
        ASSERT_TRUE(thick && hot);
        EXPECT_EQ(hot->attribute("units"), "m-1");
        const auto* warm = read.variable(schema::temperature);
        ASSERT_TRUE(warm);
        EXPECT_EQ(warm->attribute("units"), "K");
        const auto kelvin = read.floats(*warm, {0, 0, 0}, {nz, ny, nx});
        EXPECT_EQ(*std::max_element(kelvin.begin(), kelvin.end()), 1790.0f);
        EXPECT_EQ(*std::min_element(kelvin.begin(), kelvin.end()), 290.0f);
        for (size_t c = 0; c < 3; ++c) {
            const auto extinction = read.floats(*thick, {c, 0, 0, 0}, {1, nz, ny, nx}),
                       light = read.floats(*hot, {c, 0, 0, 0}, {1, nz, ny, nx});
            for (size_t k = 0; k < nz; ++k)
                for (size_t j = 0; j < ny; ++j)
                    for (size_t i = 0; i < nx; ++i) {
                        const Vec3d place(at[0][i], at[1][j], at[2][k]);  // [m]
                        const Vec3d world = up == UpAxis::Z ? place : Vec3d(place[0], place[2], -place[1]);
                        const Vec3d voxel = transform->worldToIndex(world / 10);
                        const size_t n = i + nx * (j + ny * k);
                        ASSERT_NEAR(extinction[n],
                                    (2 + double(c)) * (1 + voxel[0] + 10 * voxel[1] + 100 * voxel[2]) / 10, 1e-4);
                        const bool lit = (voxel - Vec3d(4, 3, 2)).length() < 1e-6;
                        ASSERT_NEAR(light[n], lit ? (5 + double(c)) / 10 : 0, 1e-6);
                    }
        }
    }
}

TEST(ExportNetcdf, ATemperatureIsInKelvinWhereItSaysSo)
{
    const Scratch scratch;
    for (const char* unit : {"", "K"}) {
        GridFile file = small_file(UpAxis::Z);
        const auto heat = FloatGrid::create(0.0f);
        heat->setName("heat");
        heat->setTransform(file.grids[0]->transform().copy());
        heat->tree().setValue({4, 3, 2}, 0.5f);
        if (*unit) set_text(*heat, schema::unit, unit);
        file.grids.push_back(heat);
        write_netcdf(scratch / "a.nc", file, "", false);
        const NetcdfFile read(scratch / "a.nc");
        ASSERT_TRUE(read.variable("heat"));
        EXPECT_EQ(read.variable("heat")->attribute("units"), unit);
        EXPECT_EQ(read.variable("heat")->attribute("standard_name"), *unit ? "air_temperature" : "");
    }
}

TEST(ExportNetcdf, WhatWasExportedIsImportedAgain)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    GridFile file = small_file(UpAxis::Y);
    file.grids.pop_back();
    // Without voxels of its own, so that the imported grid has the same indices.
    write_grid_file(scratch / "a.vdb", file);
    const RunResult r = shell("vdbexport a.vdb -o a.nc && vdbimport a.nc --up y --meters-per-unit 10 -o b.vdb && "
                              "vdbexport b.vdb --grid density -o b.nc",
                              there);
    ASSERT_EQ(r.status, 0) << r.err;
    const GridFile back = read_grid_file(scratch / "b.vdb");
    const auto grid = std::dynamic_pointer_cast<FloatGrid>(find_grid(back, schema::density));
    ASSERT_TRUE(grid);
    const auto before = std::dynamic_pointer_cast<FloatGrid>(file.grids[0]);
    EXPECT_EQ(grid->activeVoxelCount(), 60u);
    for (auto v = before->cbeginValueOn(); v; ++v) {
        const auto at = openvdb::Coord::round(grid->worldToIndex(before->indexToWorld(v.getCoord())));
        ASSERT_NEAR(double(grid->tree().getValue(at)), 2 * double(*v), 1e-5 * double(*v)) << v.getCoord();
    }
}

TEST(ExportNetcdf, RefusesInASentence)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    GridFile file = small_file(UpAxis::Y);
    write_grid_file(scratch / "a.vdb", file);
    file.grids[0]->transform().preRotate(0.3, openvdb::math::Y_AXIS);
    write_grid_file(scratch / "turned.vdb", file);
    const auto refused = [&](const std::string& line, int status, const std::string& words) {
        const RunResult r = shell(line, there);
        EXPECT_EQ(r.status, status) << line << r.err;
        EXPECT_NE(r.err.find(words), std::string::npos) << r.err;
    };
    refused("vdbexport turned.vdb -o a.nc", 1, "rotated or sheared");
    refused("vdbexport a.vdb -o a.hdf", 2, "ends in .nc or .usda");
    refused("vdbexport - -o a.usda < a.vdb", 2, "the input has to be a file");
    refused("vdbexport a.vdb --grid rain -o a.nc", 1, "rain");
    refused("touch a.nc && vdbexport a.vdb --no-clobber -o a.nc", 1, "exists");
    refused("vdbexport a.vdb -o a.%d.nc", 2, "has a place for the number");
    refused("cp a.vdb a.1.vdb && cp a.vdb a.2.vdb && vdbexport a.%d.vdb --frames 1,2 -o b.nc", 2, "a numbered name");
    refused("vdbexport a.%d.vdb --frames 1,2 -o b.%d.nc && test -s b.1.nc && vdbexport a.3.vdb -o b.nc", 1, "a.3.vdb");
    refused("head -c 300 a.vdb > half.vdb; vdbexport half.vdb -o a.nc", 1, "half.vdb");
}

TEST(ExportUsd, NamesFieldsClassesAndTheFileFromItsFolder)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    write_grid_file(scratch / "a.vdb", small_file(UpAxis::Z));
    const RunResult r = shell("mkdir -p usd && vdbexport a.vdb -o usd/a.usda && vdbexport a.vdb -o a.usda", there);
    ASSERT_EQ(r.status, 0) << r.err;
    const std::string text = read_text(scratch / "usd/a.usda");
    for (const char* part :
         {"#usda 1.0\n", "metersPerUnit = 10\n", "upAxis = \"Z\"\n", "def Volume \"volume\"",
          "rel field:density = </volume/density>", "rel field:vel = </volume/vel>", "def OpenVDBAsset \"density\"",
          "asset filePath = @../a.vdb@", "token fieldName = \"vel\"", "token fieldDataType = \"float3\"",
          "token fieldClass = \"fogVolume\"", "token vectorDataRoleHint = \"Vector\"",
          "float3[] extent = [(2.75, 1.875, 0.5), (5.25, 2.875, 3.5)]"})
        EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
    EXPECT_NE(read_text(scratch / "a.usda").find("asset filePath = @./a.vdb@"), std::string::npos);
    GridFile odd = small_file(UpAxis::Y);
    odd.grids[0]->setName("2 parts");
    odd.grids[1]->setName("2 parts");
    UsdVolume volume;
    volume.add(odd, "./a.vdb");
    const std::string named = volume.text();
    EXPECT_NE(named.find("OpenVDBAsset \"_2_parts\""), std::string::npos) << named;
    EXPECT_NE(named.find("OpenVDBAsset \"_2_parts_1\""), std::string::npos) << named;
    EXPECT_NE(named.find("int fieldIndex = 1"), std::string::npos) << named;
    EXPECT_THROW(volume.add(odd, "./a@b.vdb"), InputError);
    odd.grids.pop_back();
    EXPECT_THROW(volume.add(odd, "./b.vdb"), InputError) << "a grid of the first file is missing";
}

TEST(ExportUsd, FramesAreTimeSamplesOfOneVolume)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    GridFile file = small_file(UpAxis::Y);
    write_grid_file(scratch / "a.08.vdb", file);
    for (const GridBasePtr& grid : file.grids) grid->transform().postTranslate(Vec3d(1, 0, 0));
    write_grid_file(scratch / "a.09.vdb", file);
    const RunResult r = shell("vdbexport a.%02d.vdb --frames 8-9 -o a.usda && "
                              "vdbexport a.%02d.vdb --frames 8-9 -o a.%d.usda && test -s a.9.usda",
                              there);
    ASSERT_EQ(r.status, 0) << r.err;
    const std::string text = read_text(scratch / "a.usda");
    for (const char* part :
         {"startTimeCode = 8\n", "endTimeCode = 9\n", "upAxis = \"Y\"\n",
          "asset filePath.timeSamples = {\n            8: @./a.08.vdb@,\n            9: @./a.09.vdb@,\n",
          "float3[] extent = [(2.75, 1.875, 0.5), (6.25, 2.875, 3.5)]"})
        EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST(ExportNetcdf, TheExamplesOfTheHelpRunAsPrinted)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    const RunResult r = shell("vdbexport --help | sed '1,/^Examples:/d' | grep -v '^ *#' > commands && "
                              "grep -c 'vdbexport ' commands && bash -e commands && test -s lit.nc && test -s lit.usda",
                              there);
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.out.substr(0, 2), "3\n");
}

}  // namespace
}  // namespace vdbcloud::test
