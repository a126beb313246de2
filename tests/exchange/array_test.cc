// Arrays and property files: orders and types of numbers, the medium that a grid point has, and what is refused.
#include "vdbcloud/exchange/array_file.h"
#include "vdbcloud/exchange/property_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include "support/array_bytes.h"
#include "support/damage.h"
#include "support/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace vdbcloud::test {
namespace {

std::string refusal(const std::function<void()>& work)
{
    try {
        work();
    } catch (const std::exception& e) {
        return e.what();
    }
    return "read";
}

/// The value of number x, y, z of the arrays below.
float value_at(size_t x, size_t y, size_t z) { return float(1 + x + 4 * y + 12 * z); }

void expect_values(const Array& array, const std::string& what)
{
    ASSERT_EQ(array.shape, (std::array<size_t, 3>{4, 3, 2})) << what;
    for (size_t z = 0; z < 2; ++z)
        for (size_t y = 0; y < 3; ++y)
            for (size_t x = 0; x < 4; ++x)
                ASSERT_EQ(array.values[x + 4 * (y + 3 * z)], value_at(x, y, z)) << what << x << y << z;
}

/// The numbers in the order of `axes`, the first the slowest, as T.
template<typename T>
std::string in_axes(const std::string& axes, bool swap = false)
{
    const size_t n[3] = {4, 3, 2};
    size_t at[3] = {0, 0, 0};
    std::string bytes;
    const auto each = [&](size_t level, const auto& self) -> void {
        if (level == 3) {
            const T value(value_at(at[0], at[1], at[2]));
            std::string one(reinterpret_cast<const char*>(&value), sizeof value);
            if (swap) std::reverse(one.begin(), one.end());
            bytes += one;
            return;
        }
        const auto axis = size_t(axes[level] - 'x');
        for (at[axis] = 0; at[axis] < n[axis]; ++at[axis]) self(level + 1, self);
    };
    each(0, each);
    return bytes;
}

TEST(ArrayFile, RawNumbersOfEachTypeAndOrder)
{
    const Scratch scratch;
    const std::string path = scratch / "a.raw";
    const auto read = [&](const std::string& bytes, const std::string& type, const std::string& axes, bool big) {
        write_text(path, bytes);
        ArrayLayout layout;
        layout.shape = {4, 3, 2};
        layout.axes = axes;
        layout.type = type;
        layout.big_endian = big;
        expect_values(read_raw(path, layout), type + axes);
    };
    for (const char* axes : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) read(in_axes<float>(axes), "f4", axes, false);
    for (const bool big : {false, true}) {
        read(in_axes<uint8_t>("zyx", big), "u1", "zyx", big);
        read(in_axes<int16_t>("zyx", big), "i2", "zyx", big);
        read(in_axes<uint16_t>("zyx", big), "u2", "zyx", big);
        read(in_axes<int32_t>("zyx", big), "i4", "zyx", big);
        read(in_axes<uint64_t>("zyx", big), "u8", "zyx", big);
        read(in_axes<openvdb::math::half>("zyx", big), "f2", "zyx", big);
        read(in_axes<double>("zyx", big), "f8", "zyx", big);
    }
    ArrayLayout wrong;
    wrong.shape = {4, 3, 3};
    EXPECT_NE(refusal([&] { read_raw(path, wrong); }).find("192 bytes of numbers: expected 144"), std::string::npos);
    // Bytes that begin like text of UTF-8 are numbers here.
    wrong.shape = {3, 1, 1};
    wrong.type = "u1";
    write_text(path, "\xef\xbb\xbf");
    EXPECT_EQ(read_raw(path, wrong).values[0], 239.0f);
}

TEST(ArrayFile, NpyInBothOrders)
{
    const Scratch scratch;
    const std::string path = scratch / "a.npy";
    write_text(path, npy_bytes("<f4", "(2, 3, 4)", false, in_axes<float>("zyx")));
    expect_values(read_npy(path, "zyx"), "C");
    write_text(path, npy_bytes(">f8", "(4, 3, 2)", false, in_axes<double>("xyz", true)));
    expect_values(read_npy(path, "xyz"), "big");
    write_text(path, npy_bytes("<i2", "(4, 3, 2)", true, in_axes<int16_t>("zyx")));
    expect_values(read_npy(path, "xyz"), "Fortran");
    const auto refused = [&](const std::string& bytes, const std::string& words) {
        write_text(path, bytes);
        const std::string said = refusal([&] { read_npy(path, "zyx"); });
        EXPECT_NE(said.find(words), std::string::npos) << said;
    };
    refused("NUMPY", "wrong magic number");
    refused(npy_bytes("<c8", "(2, 3, 4)", false, ""), "type 'c8'");
    refused(npy_bytes("|O", "(2, 3, 4)", false, ""), "type 'O'");
    refused(npy_bytes("<f4", "(6, 4)", false, in_axes<float>("zyx")), "2 dimensions");
    refused(npy_bytes("<f4", "(2, 3, 4000000000000)", false, ""), "at most 2^28");
    refused(npy_bytes("<f4", "(2, 3, 0)", false, ""), "one or more");
    refused(npy_bytes("<f4", "(2, 3, 4)", false, in_axes<float>("zyx").substr(4)), "92 bytes of numbers");
}

TEST(ArrayFile, DamagedNpyIsReadOrRefusedInASentence)
{
    const Scratch scratch;
    const std::string path = scratch / "a.npy", whole = npy_bytes("<f4", "(2, 3, 4)", false, in_axes<float>("zyx"));
    int refused = 0;
    for (uint64_t seed = 0; seed < 300; ++seed) {
        Dice dice(seed);
        write_text(path, damaged(whole, dice));
        const std::string said = refusal([&] { read_npy(path, "zyx"); });
        if (said == "read") continue;
        ++refused;
        EXPECT_EQ(said.rfind(path, 0), 0u) << said;
    }
    EXPECT_GT(refused, 100);
}

const char* const small_properties = "T\n2 1 3\n0.02 0.04  0.5 0.52 0.54\n2\n3 2.4 1.8 1.2\n1 1.2\n"
                                     "1 1 1 288 0 0 0\n2 1 1 287.5 10 0.9 1\n1 1 2 286 5 1.0 2\n1 1 3 280 0 1 1\n";

TEST(PropertyFile, PointsAreTheMiddlesOfCells)
{
    const Scratch scratch;
    write_text(scratch / "a.prp", small_properties);
    const PropertyField field = read_property_file(scratch / "a.prp", Vec3d(0.0));
    ASSERT_EQ(field.cells.size(), 6u);
    EXPECT_NEAR(field.cells.edges[0].front(), -0.01, 1e-12);
    EXPECT_NEAR(field.cells.edges[1].back(), 0.02, 1e-12);
    EXPECT_NEAR(field.cells.edges[2].front(), 0.49, 1e-12);
    EXPECT_EQ(field.extinction[1], 10.0f);
    EXPECT_EQ(field.extinction[2], 5.0f);
    EXPECT_NEAR(field.albedo[1], 0.9, 1e-7);
    EXPECT_EQ(field.temperature[0], 288.0f);
    EXPECT_EQ(field.temperature[5], 0.0f) << "not given";
    EXPECT_NEAR(field.g, (9 * 0.8 + 5 * 0.4) / 14, 1e-12) << "weighted with scattering";
}

TEST(PropertyFile, StretchedLevelsKeepTheOpticalDepth)
{
    const Scratch scratch;
    write_text(scratch / "a.prp",
               "T\n1 1 4\n1 1  0 1 3 6\n1\n0\n1 1 1 0 1 .5 1\n1 1 2 0 2 .5 1\n1 1 3 0 3 1 1\n1 1 4 0 4 1 1\n");
    const PropertyField field = read_property_file(scratch / "a.prp", Vec3d(0.0));
    double depth = 0, scattered = 0;
    for (size_t k = 0; k < field.cells.count(2); ++k) {
        depth += double(field.extinction[k]);
        scattered += double(field.extinction[k] * field.albedo[k]);
    }
    const double size = field.cells.edges[2][1] - field.cells.edges[2][0];
    EXPECT_NEAR(size, 1, 1e-12);
    // Cells reach from -0.5 to 0.5, 2, 4.5 and 7.5.
    EXPECT_NEAR(depth * size, 1 * 1 + 2 * 1.5 + 3 * 2.5 + 4 * 3, 1e-5);
    EXPECT_NEAR(scattered * size, 0.5 * 1 + 0.5 * 2 * 1.5 + 3 * 2.5 + 4 * 3, 1e-5);
}

TEST(PropertyFile, RefusesWithTheLine)
{
    const Scratch scratch;
    const auto refused = [&](std::string text, const std::string& from, const std::string& to,
                             const std::string& words) {
        const size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos);
        write_text(scratch / "a.prp", text.replace(at, from.size(), to));
        const std::string said = refusal([&] { read_property_file(scratch / "a.prp", Vec3d(0.0)); });
        EXPECT_NE(said.find(words), std::string::npos) << said;
    };
    refused(small_properties, "T\n", "E\n", "line 1: expected T");
    refused(small_properties, "2 1 3\n", "2 1 3.5\n", "line 2: Nz 3.5");
    refused(small_properties, "0.52", "0.5", "line 3: levels");
    refused(small_properties, "10 0.9", "10 1.9", "line 8: albedo 1.9");
    refused(small_properties, "1 1 3 280", "1 1 4 280", "line 10: iz 4");
    refused(small_properties, "5 1.0 2", "5 1.0 3", "line 9: number of the phase function 3");
    refused(small_properties, "286", "warm", "line 9: temperature 'warm'");
    refused(small_properties, "280 0 1 1\n", "280 0", "ends before albedo");
}

TEST(ImportArray, ThePropertiesBecomeGridsAndMetadata)
{
    const Scratch scratch;
    write_text(scratch / "a.prp", small_properties);
    write_text(scratch / "a.raw", in_axes<float>("zyx"));
    RunOptions there;
    there.folder = scratch.path();
    const RunResult r = shell("vdbimport a.prp -o prp.vdb && vdbimport a.raw --shape 4,3,2 --cell 0.5,0.5,1 --up z "
                              "--meters-per-unit 100 -o raw.vdb",
                              there);
    ASSERT_EQ(r.status, 0) << r.err;
    const GridFile file = read_grid_file(scratch / "prp.vdb");
    const auto density = std::dynamic_pointer_cast<FloatGrid>(find_grid(file, schema::density));
    const auto ratio = std::dynamic_pointer_cast<Vec3SGrid>(find_grid(file, schema::colour));
    const auto warm = std::dynamic_pointer_cast<FloatGrid>(find_grid(file, schema::temperature));
    ASSERT_TRUE(density && ratio && warm);
    const openvdb::Coord thick(1, 0, 0), thin(0, 0, 1);
    EXPECT_EQ(density->tree().getValue(thick), 10.0f);
    EXPECT_EQ(density->indexToWorld(thick), Vec3d(0.02, 0, 0.5));
    EXPECT_NEAR(ratio->tree().getValue(thick)[0], 0.9, 1e-6);
    EXPECT_NEAR(ratio->tree().getValue(thin)[2], 1, 1e-6);
    EXPECT_EQ(warm->tree().getValue(thick), 287.5f);
    EXPECT_EQ(get_text(*warm, schema::unit, ""), "K");
    EXPECT_EQ(get_vector(*density, schema::albedo, Vec3d(0.0)), Vec3d(1.0));
    EXPECT_NEAR(get_number(*density, schema::g, 0), 9.2 / 14, 1e-12);
    EXPECT_EQ(get_number(*file.metadata, schema::meters_per_unit, 0), 1000);
    EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Z");

    const GridFile raw = read_grid_file(scratch / "raw.vdb");
    const auto grid = std::dynamic_pointer_cast<FloatGrid>(find_grid(raw, schema::density));
    ASSERT_TRUE(grid);
    EXPECT_EQ(grid->tree().getValue({3, 2, 1}), value_at(3, 2, 1));
    EXPECT_EQ(grid->indexToWorld(openvdb::Coord(3, 2, 1)), Vec3d(1.75, 1.25, 1.5));
    EXPECT_FALSE(has_meta(*grid, schema::sigma_t_per_density)) << "a density of any unit";
    EXPECT_EQ(get_number(*raw.metadata, schema::meters_per_unit, 0), 100);
    EXPECT_EQ(shell("vdbimport a.raw -o raw.vdb", there).status, 2);
    EXPECT_EQ(shell("vdbimport a.raw --shape 4,3,2.5 -o raw.vdb", there).status, 2);
}

}  // namespace
}  // namespace vdbcloud::test
