// Metadata as numbers, vectors and text, in the value types of vdbcloud and of other programs.
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/metadata.h"

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
