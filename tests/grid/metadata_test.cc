// Metadata as numbers, vectors and text, in the value types of vdbcloud and of other programs.
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include "support/grids.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::sentence;

TEST(Metadata, ReadsWrittenValuesAndDefaultsForAbsentKeys)
{
    MetaMap map;
    set_number(map, "n", 0.1);
    set_vector(map, "v", Vec3d(1, 2, 0.3));
    set_text(map, "t", "a\nb");
    EXPECT_EQ(get_number(map, "n", 5), 0.1);
    EXPECT_EQ(get_vector(map, "v", Vec3d(5)), Vec3d(1, 2, 0.3));
    EXPECT_EQ(get_text(map, "t", "otherwise"), "a\nb");
    EXPECT_TRUE(has_meta(map, "n"));
    EXPECT_FALSE(has_meta(map, "absent"));
    EXPECT_EQ(get_number(map, "absent", 5), 5);
    EXPECT_EQ(get_vector(map, "absent", Vec3d(5)), Vec3d(5));
    EXPECT_EQ(get_text(map, "absent", "otherwise"), "otherwise");
}

TEST(Metadata, ConvertsFloatIntLongAndVec3s)
{
    MetaMap map;
    map.insertMeta("float", openvdb::FloatMetadata(0.5f));
    map.insertMeta("int", openvdb::Int32Metadata(-3));
    map.insertMeta("long", openvdb::Int64Metadata(int64_t(1) << 40));
    map.insertMeta("vec3s", openvdb::Vec3SMetadata(Vec3f(1, 2, 3)));
    EXPECT_EQ(get_number(map, "float", 0), 0.5);
    EXPECT_EQ(get_number(map, "int", 0), -3);
    EXPECT_EQ(get_number(map, "long", 0), std::pow(2.0, 40));
    EXPECT_EQ(get_vector(map, "vec3s", Vec3d(0)), Vec3d(1, 2, 3));
    set_number(map, "vec3s", 2);  // replaces a value of another type
    EXPECT_EQ(get_number(map, "vec3s", 0), 2);
}

TEST(Metadata, HasTheRangesOfTheTable)
{
    const auto next = [](double x, double towards) { return std::nextafter(x, towards); };
    int bounded = 0;
    for (const schema::MetaKey& key : schema::meta_keys()) {
        if (std::string(key.type) == "string") continue;
        const bool vector = std::string(key.type) == "vec3d";
        const auto reads = [&](double x) {
            MetaMap map;
            if (vector)
                set_vector(map, key.key, Vec3d(key.range.least, x, key.range.greatest));
            else
                set_number(map, key.key, x);
            try {
                constexpr double absent = 12345.5;
                const double got =
                    vector ? get_vector(map, key.key, Vec3d(absent))[1] : get_number(map, key.key, absent);
                EXPECT_TRUE(got == x || (got == absent && !key.ours())) << key.key;
                return got == x;
            } catch (const InputError& e) {
                EXPECT_TRUE(key.ours()) << key.key << ": passed over, not refused";
                EXPECT_NE(std::string(e.what()).find("expected " + key.range.text(vector ? 3 : 1)), std::string::npos);
                return false;
            }
        };
        for (const double x : {key.range.least, key.range.greatest}) EXPECT_TRUE(reads(x)) << key.key << " = " << x;
        EXPECT_FALSE(reads(NAN)) << key.key;
        EXPECT_FALSE(reads(INFINITY)) << key.key;
        EXPECT_FALSE(reads(-INFINITY)) << key.key;
        if (key.range.least == schema::finite.least) continue;
        ++bounded;
        EXPECT_FALSE(reads(next(key.range.least, -INFINITY))) << key.key;
        EXPECT_FALSE(reads(next(key.range.greatest, INFINITY))) << key.key;
        const double within = key.range.whole ? 0.5 : 0.5 * (key.range.greatest - key.range.least);
        EXPECT_EQ(reads(key.range.least + within), !key.range.whole) << key.key;
    }
    EXPECT_GE(bounded, 12);
}

TEST(Metadata, NumbersInTextAreFiniteAndWhole)
{
    MetaMap map;
    set_numbers(map, "n", {1, 0.1, -2e-300});
    EXPECT_EQ(get_numbers(map, "n"), (std::vector<double>{1, 0.1, -2e-300}));
    EXPECT_TRUE(get_numbers(map, "absent").empty());
    for (const char* text : {"1 nan", "inf", "1 2x", "1e999", "0x1p3", "1,2"}) {
        set_text(map, "n", text);
        EXPECT_THROW(get_numbers(map, "n"), InputError) << text;
    }
}

TEST(Metadata, OfAGridIsNamedWithTheGrid)
{
    const FloatGridPtr phi = test::ball("phi", 1);
    set_number(*phi, schema::degree, 0.5);
    EXPECT_EQ(sentence<InputError>([&] { get_number(*phi, schema::degree, 1); }),
              "grid 'phi': metadata 'vdbcloud:degree' = 0.5: expected a whole number in [1, 100]");
}

TEST(Metadata, OfOtherProgramsIsPassedOver)
{
    MetaMap map;
    EXPECT_TRUE(passed_over(map).empty());
    set_text(map, schema::creator, "someone");
    set_text(map, schema::up_axis, "z");
    set_number(map, schema::meters_per_unit, 0.01);
    EXPECT_TRUE(passed_over(map).empty());
    set_number(map, schema::creator, 1);
    set_text(map, schema::up_axis, "W");
    set_text(map, schema::meters_per_unit, "feet");
    set_number(map, "vdbcloud:format", -1);
    set_number(map, "someone's", NAN);
    EXPECT_EQ(passed_over(map),
              (std::vector<std::string>{
                  "metadata 'creator' = 1 is passed over: expected text",
                  "metadata 'meters_per_unit' = feet is passed over: expected a number in [1e-30, 1e+30]",
                  "metadata 'up_axis' = W is passed over: expected Y or Z"}));
    EXPECT_EQ(get_text(map, schema::creator, "none"), "none");
    EXPECT_EQ(get_number(map, schema::meters_per_unit, 1), 1);
}

TEST(Metadata, RefusesOtherTypesAndNonFiniteValues)
{
    MetaMap map;
    set_text(map, "vdbcloud:g", "much");
    set_number(map, "nan", NAN);
    set_vector(map, "inf", Vec3d(0, INFINITY, 0));
    EXPECT_EQ(sentence<InputError>([&] { get_number(map, "vdbcloud:g", 0); }),
              "metadata 'vdbcloud:g' = much: expected a finite number");
    EXPECT_THROW(get_vector(map, "vdbcloud:g", Vec3d(0)), InputError);
    EXPECT_THROW(get_number(map, "nan", 0), InputError);
    EXPECT_THROW(get_vector(map, "inf", Vec3d(0)), InputError);
    EXPECT_THROW(get_text(map, "nan", ""), InputError);
}

}  // namespace
}  // namespace vdbcloud
