#include "vdbcloud/grid/sources.h"

#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/emission.h"
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

std::string digest_or_none(const Vec3SGrid* grid, bool counts) { return counts ? grid_digest(*grid) : schema::no_grid; }

}  // namespace

Sources sources_of(const FloatGrid& density, const Vec3SGrid* colour, const Vec3SGrid* emission)
{
    return {grid_digest(density), digest_or_none(colour, tints(colour)), digest_or_none(emission, emits(emission))};
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

void write_periodic(MetaMap& to, const std::array<bool, 3>& periodic)
{
    to.removeMeta(schema::periodic);
    if (periodic != std::array<bool, 3>{}) set_text(to, schema::periodic, periodic_text(periodic));
}

std::array<bool, 3> read_periodic(const MetaMap& from)
{
    const std::string axes = get_text(from, schema::periodic, "");
    std::array<bool, 3> periodic{};
    for (size_t a = 0; a < 3; ++a) periodic[a] = axes.find("xyz"[a]) != std::string::npos;
    if (!axes.empty() && (axes.size() > 2 || axes != periodic_text(periodic)))
        refuse(meta_name(from, schema::periodic), axes, "one or two of the letters x, y, z, in order");
    return periodic;
}

void write_ground(MetaMap& to, const std::optional<double>& albedo)
{
    to.removeMeta(schema::ground_albedo);
    if (albedo) set_number(to, schema::ground_albedo, *albedo);
}

std::optional<double> read_ground(const MetaMap& from)
{
    if (!has_meta(from, schema::ground_albedo)) return std::nullopt;
    return get_number(from, schema::ground_albedo, 0);
}

std::string periodic_text(const std::array<bool, 3>& periodic)
{
    std::string axes;
    for (size_t a = 0; a < 3; ++a)
        if (periodic[a]) axes += "xyz"[a];
    return axes.empty() ? "none" : axes;
}

}  // namespace vdbcloud
