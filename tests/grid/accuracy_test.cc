// Figures of accuracy in metadata.
#include "vdbcloud/grid/accuracy.h"

#include "support/run.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace vdbcloud::test {
namespace {

TEST(Accuracy, TravelsInMetadata)
{
    Accuracy accuracy;
    accuracy.add("defect", 2.5e-9);
    accuracy.add("residual", 3e-7);
    accuracy.left_out = {"this", "that and more"};
    MetaMap map;
    write_accuracy(map, accuracy);
    EXPECT_EQ(get_number(map, "vdbcloud:accuracy_residual", 0), 3e-7);
    for (auto entry = map.beginMeta(); entry != map.endMeta(); ++entry)
        EXPECT_TRUE(schema::meta_key(entry->first)) << entry->first;
    const Accuracy back = read_accuracy(map);
    EXPECT_EQ(back.left_out, accuracy.left_out);
    EXPECT_EQ(text_of(back), "residual 3e-07, defect 2.5e-09; left out: this, that and more");
}

TEST(Accuracy, OfANewResultReplacesTheFormer)
{
    Accuracy former, now;
    former.add("sweep_error", 0.1);
    former.left_out = {"all"};
    now.add("residual", 0);
    MetaMap map;
    write_accuracy(map, former);
    write_accuracy(map, now);
    EXPECT_EQ(text_of(read_accuracy(map)), "residual 0");
    write_accuracy(map, {});
    EXPECT_TRUE(read_accuracy(map).empty());
    EXPECT_EQ(map.metaCount(), 0u);
}

TEST(Accuracy, LeavesOutWhatIsNoNumberAndRefusesUnknownNames)
{
    Accuracy accuracy;
    accuracy.add("residual", std::nan(""));
    MetaMap map;
    write_accuracy(map, accuracy);
    EXPECT_EQ(map.metaCount(), 0u);
    accuracy.add("luck", 1);
    EXPECT_THROW(write_accuracy(map, accuracy), std::logic_error);
}

TEST(Accuracy, HasTheFiguresOfTheDocument)
{
    const std::string page = read_text(std::string(VDBCLOUD_SOURCE) + "/docs/format.md");
    for (const AccuracyKind& kind : accuracy_kinds())
        EXPECT_NE(page.find("| `" + std::string(kind.name) + "` | " + kind.meaning + " |"), std::string::npos)
            << kind.name;
}

}  // namespace
}  // namespace vdbcloud::test
