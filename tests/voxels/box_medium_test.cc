// Media of boxes: which voxels a box fills, and which box wins.
#include "vdbcloud/voxels/box_medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

const Vec3d cell(2, 1, 0.5);

TEST(BoxMedium, ABoxFillsTheVoxelsWhoseCentresLieInIt)
{
    const BoxMedium medium = box_medium({{Vec3d(-4, 0, 1), Vec3d(2, 3, 2), 0.25, 0}}, cell);
    EXPECT_FALSE(medium.emission);
    EXPECT_EQ(medium.extinction->activeVoxelCount(), 3u * 3 * 2);
    const auto box = medium.extinction->evalActiveVoxelBoundingBox();
    EXPECT_EQ(box.min(), Coord(-2, 0, 2));
    EXPECT_EQ(box.max(), Coord(0, 2, 3));
    EXPECT_EQ(medium.extinction->tree().getValue(Coord(-2, 0, 2)), 0.25f);
    const Vec3d centre = medium.extinction->indexToWorld(Coord(-2, 0, 2));
    EXPECT_NEAR((centre - Vec3d(-3, 0.5, 1.25)).length(), 0, 1e-12);
}

TEST(BoxMedium, AFaceBetweenTwoBoxesBelongsToOneOfThem)
{
    // Faces within voxels: each voxel is in exactly one of two boxes that touch.
    const BoxMedium medium =
        box_medium({{Vec3d(0), Vec3d(9, 4, 4), 1, 0}, {Vec3d(9, 0, 0), Vec3d(20, 4, 4), 2, 0}}, cell);
    EXPECT_EQ(medium.extinction->activeVoxelCount(), 10u * 4 * 8);
    EXPECT_EQ(medium.extinction->tree().getValue(Coord(3, 0, 0)), 1.0f);
    EXPECT_EQ(medium.extinction->tree().getValue(Coord(4, 0, 0)), 2.0f) << "the centre at 9 is the second box's";
}

TEST(BoxMedium, ALaterBoxReplacesAnEarlierOne)
{
    const BoxMedium medium = box_medium({{Vec3d(0), Vec3d(8), 1, 3}, {Vec3d(2), Vec3d(6), 0, 0}}, cell);
    EXPECT_EQ(medium.extinction->activeVoxelCount(), 4u * 8 * 16 - 2 * 4 * 8);
    EXPECT_FALSE(medium.extinction->tree().isValueOn(Coord(1, 2, 4))) << "a hole";
    ASSERT_TRUE(medium.emission);
    EXPECT_EQ(medium.emission->activeVoxelCount(), medium.extinction->activeVoxelCount());
    EXPECT_EQ(medium.emission->tree().getValue(Coord(0, 0, 0)), Vec3f(3));
    EXPECT_EQ(medium.emission->tree().getValue(Coord(1, 2, 4)), Vec3f(0));
}

TEST(BoxMedium, RefusesBoxesWithoutVolumeAndValuesThatCannotBe)
{
    for (const double bad : {-1.0, double(NAN), double(INFINITY)}) {
        EXPECT_THROW(box_medium({{Vec3d(0), Vec3d(1), bad, 0}}, cell), InputError);
        EXPECT_THROW(box_medium({{Vec3d(0), Vec3d(1), 1, bad}}, cell), InputError);
        EXPECT_THROW(box_medium({{Vec3d(0), Vec3d(1, 1, bad), 1, 0}}, cell), InputError);
    }
    EXPECT_THROW(box_medium({{Vec3d(0), Vec3d(1, 0, 1), 1, 0}}, cell), InputError);
    EXPECT_THROW(box_medium({{Vec3d(0), Vec3d(1e5), 1, 0}}, cell), InputError) << "1e15 voxels";
    EXPECT_THROW(box_medium({{Vec3d(-1e12, 0, 0), Vec3d(1), 1, 0}}, cell), InputError);
}

}  // namespace
}  // namespace vdbcloud::test
