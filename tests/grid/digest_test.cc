// Fingerprints: equal for equal contents, different after the smallest change, independent of how bytes are split.
#include "vdbcloud/grid/digest.h"

#include "support/grids.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::ball;

TEST(Digest, DoesNotDependOnSplittingTheBytes)
{
    std::string bytes;
    for (int k = 0; k < 1000; ++k) bytes += char(k * k);
    Digest whole;
    whole.add(bytes.data(), bytes.size());
    for (const size_t step : {1, 7, 31, 32, 33, 500}) {
        Digest parts;
        for (size_t at = 0; at < bytes.size(); at += step)
            parts.add(bytes.data() + at, std::min(step, bytes.size() - at));
        EXPECT_EQ(parts.hex(), whole.hex()) << step;
    }
    EXPECT_EQ(whole.hex().size(), 32u);
    EXPECT_EQ(whole.uuid().size(), 36u);
}

TEST(Digest, MatchesXxhsumH128)
{
    // Output of `xxhsum -H128` for an empty file and for "abc".
    Digest digest;
    EXPECT_EQ(digest.hex(), "99aa06d3014798d86001c324468d497f");
    digest.add("abc", 3);
    EXPECT_EQ(digest.hex(), "06b05ab6733a618578af5f94892f3950");
    EXPECT_EQ(digest.uuid(), "06b05ab6-733a-6185-78af-5f94892f3950");
}

TEST(Digest, ChangesWithEachBitAndTheLength)
{
    std::set<std::string> seen;
    std::string bytes(70, '\0');
    const auto note = [&] {
        Digest digest;
        digest.add(bytes.data(), bytes.size());
        return seen.insert(digest.hex()).second;
    };
    EXPECT_TRUE(note());
    for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        bytes[bit / 8] = char(1 << bit % 8);
        EXPECT_TRUE(note()) << bit;
        bytes[bit / 8] = 0;
    }
    for (const size_t size : {0, 1, 31, 32, 64, 69, 71}) {
        bytes.assign(size, '\0');
        EXPECT_TRUE(note()) << size;
    }
}

TEST(GridDigest, ChangesWithTransformBackgroundTopologyAndValuesOnly)
{
    const auto changed = [](const std::function<void(FloatGrid&)>& change) {
        const auto grid = ball("density");
        grid->tree().addTile(1, Coord(64, 0, 0), 0.5f, true);
        change(*grid);
        return grid_digest(*grid);
    };
    const std::string same = changed([](FloatGrid&) {});
    EXPECT_EQ(changed([](FloatGrid& g) { g.setName("other"), g.setSaveFloatAsHalf(true); }), same);
    EXPECT_EQ(changed([](FloatGrid& g) { g.tree().touchLeaf(Coord(900)); }), same) << "a leaf with nothing active";
    const std::vector<std::function<void(FloatGrid&)>> changes = {
        [](FloatGrid& g) {
            g.tree().setValue(Coord(1, 2, 3), std::nextafter(g.tree().getValue(Coord(1, 2, 3)), 1.0f));
        },
        [](FloatGrid& g) { g.tree().setValueOff(Coord(0)); },
        [](FloatGrid& g) { g.tree().setValueOn(Coord(100, 0, 0)); },
        [](FloatGrid& g) { g.tree().addTile(1, Coord(64, 0, 0), 0.25f, true); },
        [](FloatGrid& g) { g.tree().addTile(1, Coord(72, 0, 0), 0.5f, true); },
        [](FloatGrid& g) { g.transform().postTranslate(Vec3d(0, 1e-9, 0)); },
        [](FloatGrid& g) { g.transform().preScale(2.0); },
        [](FloatGrid& g) { g.tree().root().setBackground(1.0f, false); },
    };
    std::set<std::string> seen = {same};
    for (size_t k = 0; k < changes.size(); ++k) EXPECT_TRUE(seen.insert(changed(changes[k])).second) << "change " << k;
}

TEST(GridDigest, ChangesWithEachComponentOfAVector)
{
    const auto changed = [](const Vec3f& by) {
        const auto grid = Vec3SGrid::create(Vec3f(1.0f));
        grid->tree().addTile(1, Coord(64, 0, 0), Vec3f(0.5f), true);
        grid->tree().setValue(Coord(1, 2, 3), Vec3f(1, 2, 3) + by);
        return grid_digest(*grid);
    };
    std::set<std::string> seen;
    for (const Vec3f& by : {Vec3f(0, 0, 0), Vec3f(1e-6f, 0, 0), Vec3f(0, 1e-6f, 0), Vec3f(0, 0, 1e-6f)})
        EXPECT_TRUE(seen.insert(changed(by)).second) << by;
    EXPECT_EQ(seen.count(changed(Vec3f(0.0f))), 1u);
}

}  // namespace
}  // namespace vdbcloud
