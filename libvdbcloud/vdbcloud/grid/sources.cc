#include "vdbcloud/grid/sources.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"

namespace vdbcloud {

namespace {

struct Source {
    const char* grid;
    const char* key;
    std::string Sources::*digest;
};

constexpr Source table[] = {{schema::density, schema::density_digest, &Sources::density},
                            {schema::colour, schema::colour_digest, &Sources::colour},
                            {schema::emission, schema::emission_digest, &Sources::emission}};

std::string digest_or_none(const Vec3SGrid* grid) { return grid ? grid_digest(*grid) : schema::no_grid; }

}  // namespace

Sources sources_of(const FloatGrid& density, const Vec3SGrid* colour, const Vec3SGrid* emission)
{
    return {grid_digest(density), digest_or_none(colour), digest_or_none(emission)};
}

void write_sources(MetaMap& to, const Sources& sources)
{
    for (const Source& source : table) set_text(to, source.key, sources.*source.digest);
}

std::string changed_source(const MetaMap& result, const Sources& now)
{
    for (const Source& source : table)
        if (has_meta(result, source.key) && get_text(result, source.key, "") != now.*source.digest) return source.grid;
    return {};
}

}  // namespace vdbcloud
