// Fields of cloud models: the extinction of their water, where their cells are, and what is refused.
#include "vdbcloud/exchange/cloud_field.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/units.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include "support/damage.h"
#include "support/netcdf_maker.h"
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbcloud::test {
namespace {

/// "threw: MESSAGE" of reading a field.
std::string refusal(const std::string& path, const CloudFieldOptions& options = {})
{
    try {
        read_cloud_field(path, options, 0);
    } catch (const InputError& e) {
        return e.what();
    } catch (const IoError& e) {
        return e.what();
    }
    return "read";
}

bool says(const CloudField& field, const std::string& words)
{
    for (const std::string& line : field.said)
        if (line.find(words) != std::string::npos) return true;
    return false;
}

TEST(Units, AreProductsOfPowers)
{
    const auto content = parse_unit("g m-3"), same = parse_unit("g/m^3"), powers = parse_unit("10^-3 kg m**-3");
    ASSERT_TRUE(content && same && powers);
    EXPECT_TRUE(content->same_kind({1, 1, -3}));
    EXPECT_NEAR(content->factor, 1e-3, 1e-18);
    EXPECT_NEAR(same->factor, 1e-3, 1e-18);
    EXPECT_NEAR(powers->factor, 1e-3, 1e-18);
    for (const char* ratio : {"g/kg", "g kg-1", "g kg^-1", "g.kg-1", "1e-3", "10-3 1"}) {
        const auto unit = parse_unit(ratio);
        if (std::string(ratio) == "10-3 1") {
            EXPECT_FALSE(unit) << ratio;
            continue;
        }
        ASSERT_TRUE(unit) << ratio;
        EXPECT_TRUE(unit->same_kind({})) << ratio;
        EXPECT_NEAR(unit->factor, 1e-3, 1e-18) << ratio;
    }
    for (const char* length : {"um", "micron", "\xC2\xB5m", "1e-6 m", "10^-6 m"}) {
        const auto unit = parse_unit(length);
        ASSERT_TRUE(unit && unit->same_kind({1, 0, 1})) << length;
        EXPECT_NEAR(unit->factor, 1e-6, 1e-20) << length;
    }
    for (const char* none : {"", "degrees_north", "furlong", "kg m-", "m^99", "%"})
        EXPECT_FALSE(parse_unit(none)) << none;
}

TEST(CloudField, ExtinctionIsThatOfTheDrops)
{
    const Scratch scratch;
    for (const bool hdf5 : {false, true}) {
        const std::string path = scratch / (hdf5 ? "model4.nc" : "model.nc");
        write_model(path, hdf5);
        EXPECT_EQ(cloud_field_times(path, {}), 2u);
        CloudFieldOptions options;
        options.effective_radius = 12e-6;
        options.cell = Vec3d(0, 0, 50);  // the edges of the levels are multiples
        for (int t = 0; t < 2; ++t) {
            const CloudField field = read_cloud_field(path, options, size_t(t));
            ASSERT_EQ(field.cells.count(0), 5u);
            ASSERT_EQ(field.cells.count(1), 4u);
            ASSERT_EQ(field.cells.count(2), 9u);
            EXPECT_NEAR(field.cells.edges[0][0], 0, 1e-9);
            EXPECT_NEAR(field.cells.edges[0][5], 250, 1e-9);
            const int level[] = {0, 0, 1, 1, 1, 2, 2, 2, 2};
            size_t at = 0;
            for (int k = 0; k < 9; ++k)
                for (int j = 0; j < 4; ++j)
                    for (int i = 0; i < 5; ++i, ++at) {
                        const double expected = 1.5 * model_water(t, i, j, level[k]) / (1000 * 12e-6);
                        EXPECT_NEAR(field.extinction[at] / expected, 1, 2e-6) << t << k << j << i;
                    }
            EXPECT_TRUE(field.used_radius);
            EXPECT_TRUE(says(field, "density of air from 'p' and 'T'"));
        }
    }
}

TEST(CloudField, StretchedLevelsKeepTheWaterOfEachColumn)
{
    const Scratch scratch;
    write_model(scratch / "model.nc");
    for (const double height : {0.0, 37.0, 450.0}) {
        CloudFieldOptions options;
        options.cell = Vec3d(0, 0, height);
        const CloudField field = read_cloud_field(scratch / "model.nc", options, 0);
        const auto& z = field.cells.edges[2];
        EXPECT_NEAR(z[1] - z[0], height > 0 ? height : 100, 1e-9) << "the smallest level";
        double water = 0;
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 5; ++i) {
                double depth = 0, expected = 0;
                for (size_t k = 0; k < field.cells.count(2); ++k)
                    depth += (z[1] - z[0]) * double(field.extinction[size_t(i) + 5 * (size_t(j) + 4 * k)]);
                for (int k = 0; k < 3; ++k) {
                    const double thick = model_levels()[size_t(k) + 1] - model_levels()[size_t(k)];
                    expected += 1.5 * model_water(0, i, j, k) / (1000 * 10e-6) * thick;
                    water += model_water(0, i, j, k) * thick * 50 * 20;
                }
                EXPECT_NEAR(depth / expected, 1, 2e-6) << height << ": " << i << ", " << j;
            }
        EXPECT_NEAR(field.water / water, 1, 2e-6);
    }
}

TEST(CloudField, ReadsRadiusContentAndAxesByOtherNames)
{
    const Scratch scratch;
    const std::string path = scratch / "other.nc";
    {
        NetcdfMaker file(path);
        for (const auto& [name, size] : std::map<std::string, size_t>{{"east", 2}, {"north", 2}, {"up", 2}})
            file.dimension(name, size);
        file.variable("east", {"east"}, {100, 0}, {{"units", "m"}, {"standard_name", "projection_x_coordinate"}});
        file.variable("north", {"north"}, {0, 50}, {{"units", "m"}, {"axis", "Y"}});
        file.variable("depth", {"up"}, {20, 60}, {{"units", "m"}, {"positive", "down"}});
        // The fastest dimension is vertical.
        file.variable("wet", {"north", "east", "up"}, {1, 2, 3, 4, 5, 6, 7, -8}, {{"units", "g m-3"}});
        file.variable("r", {"east"}, {10, 0}, {{"units", "um"}});
    }
    CloudFieldOptions options;
    options.variables = {{"water", "wet"}, {"radius", "r"}, {"z", "depth"}};
    options.effective_radius = 20e-6;
    const CloudField field = read_cloud_field(path, options, 0);
    EXPECT_NEAR(field.cells.edges[2].front(), -80, 1e-9);
    EXPECT_NEAR(field.cells.edges[2].back(), 0, 1e-9);
    EXPECT_NEAR(field.cells.edges[0].front(), -50, 1e-9);
    const auto at = [&](int i, int j, int k) { return double(field.extinction[size_t(i + 2 * (j + 2 * k))]); };
    // East rises: file index 1 comes first, where the radius is missing. Depth rises downwards.
    EXPECT_NEAR(at(0, 0, 1) / (1.5 * 3e-3 / (1000 * 20e-6)), 1, 1e-6);
    EXPECT_NEAR(at(1, 0, 1) / (1.5 * 1e-3 / (1000 * 10e-6)), 1, 1e-6);
    EXPECT_NEAR(at(1, 0, 0) / (1.5 * 2e-3 / (1000 * 10e-6)), 1, 1e-6);
    EXPECT_NEAR(at(1, 1, 1) / (1.5 * 5e-3 / (1000 * 10e-6)), 1, 1e-6);
    EXPECT_EQ(at(0, 1, 0), 0);
    EXPECT_TRUE(says(field, "1 negative values of 'wet' taken as 0"));
    EXPECT_TRUE(says(field, "20 um in 3 cells"));
}

TEST(CloudField, RefusesWhatItWouldHaveToGuess)
{
    const Scratch scratch;
    const std::string path = scratch / "bare.nc";
    const auto make = [&](const std::map<std::string, std::string>& units, bool coordinate) {
        NetcdfMaker file(path);
        file.dimension("x", 2);
        file.dimension("y", 1);
        file.dimension("z", 1);
        if (coordinate) file.variable("x", {"x"}, {0, 1}, {{"units", "degrees_east"}});
        file.variable("ql", {"z", "y", "x"}, {1e-3, 1e-3}, units);
    };
    CloudFieldOptions cells;
    cells.cell = Vec3d(10, 10, 10);
    const auto expect = [&](const std::string& said, const std::string& words) {
        EXPECT_NE(said.find(words), std::string::npos) << said;
        EXPECT_EQ(said.rfind(path, 0), 0u) << said;
    };
    make({}, false);
    expect(refusal(path), "no coordinate: expected --cell");
    expect(refusal(path, cells), "ql: no units");
    make({{"units", "kg/kg"}}, false);
    expect(refusal(path, cells), "--air-density");
    make({{"units", "m"}}, false);
    expect(refusal(path, cells), "units 'm': expected kg/m^3");
    make({{"units", "spoons"}}, false);
    expect(refusal(path, cells), "units 'spoons'");
    make({{"units", "g m-3"}}, true);
    CloudFieldOptions flat = cells;
    flat.cell = Vec3d(0, 10, 10);
    expect(refusal(path, flat), "x: units 'degrees_east'");
    EXPECT_TRUE(says(read_cloud_field(path, cells, 0), "coordinate 'x' [degrees_east] is no length: cells of 10 m"));
    make({{"units", "kg/kg"}}, true);
    CloudFieldOptions missing = cells;
    missing.variables = {{"water", "rain"}};
    expect(refusal(path, missing), "no variable 'rain' (water): the file has x, ql");
    EXPECT_NE(refusal(scratch / "none.nc").find("cannot read"), std::string::npos);

    CloudFieldOptions told = cells;
    told.cell = Vec3d(1, 10, 10);
    told.units = {{"ql", "g/kg"}, {"x", "m"}};
    told.air_density = 1;
    const CloudField field = read_cloud_field(path, told, 0);
    EXPECT_NEAR(field.extinction[0] / (1.5 * 1e-6 / (1000 * 10e-6)), 1, 1e-6);
    EXPECT_TRUE(field.used_air_density);
}

TEST(CloudField, APerturbationIsNoPressure)
{
    const Scratch scratch;
    {
        NetcdfMaker file(scratch / "a.nc");
        for (const char* axis : {"z", "y", "x"}) file.dimension(axis, 1);
        file.variable("QCLOUD", {"z", "y", "x"}, {1e-3}, {{"units", "kg kg-1"}});
        file.variable("P", {"z", "y", "x"}, {-120}, {{"units", "Pa"}});
        file.variable("T", {"z", "y", "x"}, {4}, {{"units", "K"}});
    }
    CloudFieldOptions options;
    options.cell = Vec3d(10, 10, 10);
    EXPECT_NE(refusal(scratch / "a.nc", options).find("P = -120 Pa: expected 1 to 2e+05. A perturbation?"),
              std::string::npos)
        << refusal(scratch / "a.nc", options);
    options.air_density = 1.1;
    EXPECT_NEAR(read_cloud_field(scratch / "a.nc", options, 0).extinction[0] / (1.5 * 1.1e-3 / 1e-2), 1, 1e-6);
}

TEST(CloudField, MissingValuesAndPackedOnesAreUnderstood)
{
    const Scratch scratch;
    const std::string path = scratch / "packed.nc";
    {
        NetcdfMaker file(path);
        for (const char* axis : {"z", "y", "x"}) file.dimension(axis, axis[0] == 'x' ? 3 : 1);
        file.variable("lwc", {"z", "y", "x"}, {5, -999, 7}, {{"units", "g m-3"}});
        file.number("lwc", "scale_factor", 0.1);
        file.number("lwc", "add_offset", 1);
        file.number("lwc", "missing_value", -999);
    }
    CloudFieldOptions options;
    options.cell = Vec3d(10, 10, 10);
    const CloudField field = read_cloud_field(path, options, 0);
    EXPECT_NEAR(field.extinction[0] / (1.5 * 1.5e-3 / 1e-2), 1, 1e-6);
    EXPECT_EQ(field.extinction[1], 0);
    EXPECT_NEAR(field.extinction[2] / (1.5 * 1.7e-3 / 1e-2), 1, 1e-6);
    EXPECT_TRUE(says(field, "1 missing values"));
}

TEST(CloudField, DamagedFilesAreReadOrRefusedInASentence)
{
    const Scratch scratch;
    int refused = 0;
    for (const bool hdf5 : {false, true}) {
        const std::string path = scratch / "model.nc";
        write_model(path, hdf5);
        const std::string whole = read_text(path);
        for (uint64_t seed = 0; seed < 40; ++seed) {
            Dice dice(seed);
            write_text(scratch / "damaged.nc", damaged(whole, dice));
            const std::string said = refusal(scratch / "damaged.nc");
            if (said == "read") continue;
            ++refused;
            EXPECT_EQ(said.rfind(scratch / "damaged.nc", 0), 0u) << said;
        }
        for (const size_t missing : {size_t(8), whole.size() / 2}) {
            write_text(scratch / "short.nc", whole.substr(0, whole.size() - missing));
            EXPECT_NE(refusal(scratch / "short.nc"), "read") << hdf5 << missing;
        }
    }
    EXPECT_GT(refused, 5);
}

/// A report of a program that ends well.
nlohmann::json report_of(std::vector<std::string> words)
{
    words[0] = program(words[0]);
    words.insert(words.end(), {"-q", "--json", "-"});
    const RunResult r = run(words);
    EXPECT_EQ(r.status, 0) << r.err;
    return nlohmann::json::parse(r.out, nullptr, false);
}

TEST(ImportModel, AnOptionNeedsOneTimeThatItChanges)
{
    // A model starts without a cloud.
    const Scratch scratch;
    {
        NetcdfMaker file(scratch / "dry.nc");
        for (const char* axis : {"time", "z", "y", "x"}) file.dimension(axis, *axis == 'x' || *axis == 't' ? 2 : 1);
        file.variable("lwc", {"time", "z", "y", "x"}, {0, 0, 1, 2}, {{"units", "g m-3"}});
    }
    RunOptions there;
    there.folder = scratch.path();
    const std::string line = "vdbimport dry.nc --cell 10,10,10 --effective-radius 5 -o d.%02d.vdb";
    const RunResult r = shell(line, there);
    EXPECT_EQ(r.status, 0) << r.err;
    const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(read_grid_file(scratch / "d.01.vdb"), "density"));
    EXPECT_NEAR(density->tree().getValue(openvdb::Coord(1, 0, 0)), 1.5 * 2e-3 / 1e3 / 5e-6, 1e-6);
    const RunResult dry = shell(line + " --times 0", there);
    EXPECT_EQ(dry.status, 2);
    EXPECT_NE(dry.err.find("--effective-radius has no effect without cells of water"), std::string::npos) << dry.err;
}

TEST(ImportModel, TimesBecomeFramesWithUnitsAndUpAxis)
{
    const Scratch scratch;
    write_model(scratch / "model.nc");
    RunOptions there;
    there.folder = scratch.path();
    const RunResult one = shell("vdbimport model.nc -o cloud.vdb", there);
    EXPECT_EQ(one.status, 2);
    EXPECT_NE(one.err.find("holds 2 times: expected one, as --times 0"), std::string::npos) << one.err;
    EXPECT_EQ(shell("vdbimport model.nc --times 2 -o cloud.vdb", there).status, 2);
    EXPECT_EQ(shell("vdbimport model.nc --variable soup=qc --times 1 -o cloud.vdb", there).status, 2);
    const RunResult r =
        shell("vdbimport model.nc -o cloud.%02d.vdb && vdbimport model.nc --up y --meters-per-unit 1000 "
              "--times 1 -o up.vdb",
              there);
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.err.find("effective radius 10 um, assumed"), std::string::npos) << r.err;
    for (int t = 0; t < 2; ++t) {
        const GridFile file = read_grid_file(scratch / ("cloud.0" + std::to_string(t) + ".vdb"));
        EXPECT_EQ(get_number(*file.metadata, schema::meters_per_unit, 0), 1);
        EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Z");
        const auto grid = std::dynamic_pointer_cast<FloatGrid>(find_grid(file, schema::density));
        ASSERT_TRUE(grid);
        EXPECT_EQ(get_vector(*grid, schema::sigma_t_per_density, Vec3d(0.0)), Vec3d(1.0));
        const auto at = openvdb::Coord::round(grid->worldToIndex(Vec3d(75, 50, 50)));
        EXPECT_NEAR(double(grid->tree().getValue(at)) / (1.5 * model_water(t, 1, 2, 0) / 1e-2), 1, 2e-6);
    }
    // World x, -z, y [km] are the model's x, y, z.
    const GridFile up = read_grid_file(scratch / "up.vdb");
    EXPECT_EQ(get_number(*up.metadata, schema::meters_per_unit, 0), 1000);
    EXPECT_EQ(get_text(*up.metadata, schema::up_axis, ""), "Y");
    const auto grid = std::dynamic_pointer_cast<FloatGrid>(find_grid(up, schema::density));
    const auto at = openvdb::Coord::round(grid->worldToIndex(Vec3d(0.075, 0.05, -0.05)));
    EXPECT_NEAR(double(grid->tree().getValue(at)) / (1.5e3 * model_water(1, 1, 2, 0) / 1e-2), 1, 2e-6);
}

/// A body of 12 x 16 x 6 cells of 20 x 10 x 40 m, the densest in the middle.
void write_flat_cells(const std::string& path)
{
    NetcdfMaker file(path);
    file.dimension("z", 6);
    file.dimension("y", 16);
    file.dimension("x", 12);
    std::vector<double> x, y, z, water;
    for (int i = 0; i < 12; ++i) x.push_back(20 * i + 10);
    for (int j = 0; j < 16; ++j) y.push_back(10 * j + 5);
    for (int k = 0; k < 6; ++k) z.push_back(40 * k + 20);
    for (const double h : z)
        for (const double b : y)
            for (const double a : x)
                water.push_back(0.02 + 0.04 * std::exp(-(std::pow(a - 120, 2) + std::pow(b - 80, 2)) / 5000 - h / 300));
    file.variable("x", {"x"}, x, {{"units", "m"}});
    file.variable("y", {"y"}, y, {{"units", "m"}});
    file.variable("z", {"z"}, z, {{"units", "m"}});
    file.variable("lwc", {"z", "y", "x"}, water, {{"units", "g/m3"}});
}

TEST(ImportModel, CellsThatAreNoCubesAreTheSameBodyAsCubes)
{
    const Scratch scratch;
    write_flat_cells(scratch / "flat.nc");
    const std::string flat = scratch / "flat.vdb", cubes = scratch / "cubes.vdb";
    const auto one = report_of({"vdbimport", scratch / "flat.nc", "-o", flat}),
               other = report_of({"vdbimport", scratch / "flat.nc", "--cell", "10,10,10", "-o", cubes});
    EXPECT_EQ(double(one["counts"]["voxels"]), 12 * 16 * 6);
    EXPECT_EQ(double(other["counts"]["voxels"]), 24 * 16 * 24);
    EXPECT_NEAR(double(one["field"]["mean_optical_depth"]) / double(other["field"]["mean_optical_depth"]), 1, 1e-6);
    double power[2], light[2];
    for (int k = 0; k < 2; ++k) {
        const std::string lit = scratch / (k ? "cubes.lit.vdb" : "flat.lit.vdb");
        const auto solved = report_of({"p1solve", k ? cubes : flat, "--sun", "0.3,0.2,1", "--albedo", "0.95", "--g",
                                       "0.5", "--reentry-rays", "0", "--heating", "-o", lit});
        power[k] = solved["channels"]["r"]["budget"]["absorbed"];
        RunOptions there;
        there.folder = scratch.path();
        const RunResult r = shell("render '" + lit +
                                      "' -q --resolution 32 --camera 120,81,900 --look-at 120,80,120 "
                                      "--fov 40 -o picture.exr && oiiotool --stats picture.exr "
                                      "| awk '/Stats Avg/ { print $3 }'",
                                  there);
        EXPECT_EQ(r.status, 0) << r.err;
        light[k] = std::strtod(r.out.c_str(), nullptr);
        EXPECT_GT(light[k], 0) << r.out;
    }
    // The trilinear fringe is a voxel wide, and P1's boundary layer is resolved to a voxel: the bodies differ by what
    // 20 x 10 x 40 m do not resolve.
    EXPECT_NEAR(light[0] / light[1], 1, 0.1);
    EXPECT_NEAR(power[0] / power[1], 1, 0.06);
}

}  // namespace
}  // namespace vdbcloud::test
