#include "vdbcloud/grid/up_axis.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

namespace vdbcloud {

const char* word(UpAxis up)
{
    for (const auto& [text, axis] : up_axis_words)
        if (axis == up) return text;
    return "";
}

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
        for (const auto& [upper, axis] : up_axis_words)
            if ((text[0] & ~0x20) == upper[0]) return axis;
    return std::nullopt;
}

void write_up_axis(MetaMap& to, UpAxis up) { set_text(to, schema::up_axis, word(up)); }

}  // namespace vdbcloud
