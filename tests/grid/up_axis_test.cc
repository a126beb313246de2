// The up axis: word, index and vector agree, and metadata keeps the axis.
#include "vdbcloud/grid/up_axis.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

TEST(UpAxis, MapsToWordIndexAndUnitVector)
{
    EXPECT_STREQ(up_axis_words.word(UpAxis::Y), "Y");
    EXPECT_STREQ(up_axis_words.word(UpAxis::Z), "Z");
    EXPECT_EQ(index_of(UpAxis::Y), 1);
    EXPECT_EQ(index_of(UpAxis::Z), 2);
    EXPECT_EQ(vector_of(UpAxis::Y), Vec3d(0, 1, 0));
    EXPECT_EQ(vector_of(UpAxis::Z), Vec3d(0, 0, 1));
}

TEST(UpAxis, RoundTripsThroughMetadata)
{
    for (const auto& [axis, text] : up_axis_words.entries) {
        MetaMap meta;
        EXPECT_FALSE(read_up_axis(meta));
        write_up_axis(meta, axis);
        EXPECT_EQ(get_text(meta, "up_axis", ""), text);
        EXPECT_EQ(read_up_axis(meta), axis);
    }
}

TEST(UpAxis, ReadsLowerCaseAndIgnoresOtherWords)
{
    for (const auto& [text, expected] : {std::pair<const char*, std::optional<UpAxis>>{"z", UpAxis::Z},
                                         {"y", UpAxis::Y},
                                         {"X", std::nullopt},
                                         {"", std::nullopt},
                                         {"Z up", std::nullopt}}) {
        MetaMap meta;
        set_text(meta, "up_axis", text);
        EXPECT_EQ(read_up_axis(meta), expected) << text;
    }
}

}  // namespace
}  // namespace vdbcloud
