#include "fuzz.h"

#include "vdbcloud/render/merge.h"

void vdbcloud::test::judge(std::string_view bytes)
{
    const auto ranges = joined(read_ranges(std::string(bytes)));
    for (size_t k = 0; k < ranges.size(); ++k) {
        demand(ranges[k].first < ranges[k].end, "ranges that hold something");
        demand(k == 0 || ranges[k - 1].end < ranges[k].first, "rising ranges, neighbours joined");
    }
    std::string text;
    for (const SampleRange& range : ranges) text += range_text(range) + " ";
    demand(ranges.empty() || joined(read_ranges(text)) == ranges, "text that is read back");
}
