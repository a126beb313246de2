#include "vdbcloud/grid/up_axis.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

namespace vdbcloud {

Vec3d vector_of(UpAxis up)
{
    Vec3d v(0.0);
    v[index_of(up)] = 1;
    return v;
}

std::optional<UpAxis> read_up_axis(const MetaMap& from)
{
    const std::string text = get_text(from, schema::up_axis, "");
    if (text.size() == 1)
        for (const auto& [axis, upper] : up_axis_words.entries)
            if ((text[0] & ~0x20) == upper[0]) return axis;
    return std::nullopt;
}

void write_up_axis(MetaMap& to, UpAxis up) { set_text(to, schema::up_axis, up_axis_words.word(up)); }

}  // namespace vdbcloud
