#include "overlap.h"

#include "inputs.h"
#include "scaled_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/mixture.h"

#include <algorithm>

namespace vdbcloud {

namespace {

std::vector<DeltaScaling> scalings_in(const Overlap& overlap, const Scene& scene)
{
    std::vector<DeltaScaling> scalings;
    for (size_t v = 0; v < overlap.count; ++v) scalings.push_back(scene.volumes[overlap.first + v].collided.scaling);
    return scalings;
}

}  // namespace

std::vector<MediumPart> Overlap::parts(const Scene& scene) const
{
    std::vector<MediumPart> parts;
    for (size_t v = first; v < first + count; ++v) {
        const Volume& volume = scene.volumes[v];
        parts.push_back({volume.density->getName(), volume.density, volume.medium, volume.colour, nullptr});
    }
    return parts;
}

Overlap overlap_of(const std::vector<GridFile>& files, size_t v)
{
    const auto follows = [&](size_t k) {
        return k > 0 && files[k].path == files[k - 1].path && app::is_further_medium(files[k]);
    };
    Overlap overlap{v, 1};
    while (follows(overlap.first)) --overlap.first;
    while (overlap.first + overlap.count < files.size() && follows(overlap.first + overlap.count)) ++overlap.count;
    return overlap;
}

std::vector<Overlap> overlaps_of(const std::vector<GridFile>& files)
{
    std::vector<Overlap> all;
    for (size_t v = 0; v < files.size(); v += all.back().count) all.push_back(overlap_of(files, v));
    return all;
}

bool is_mixture(const GridBase& phi) { return has_meta(phi, schema::mixture); }

void share_collided(const GridFile& file, const Overlap& overlap, Scene& scene)
{
    const CollidedLight light = scene.volumes[overlap.first].collided;
    if (!light.phi) return;
    const std::string made_for = get_text(*light.phi, schema::mixture, "");
    const auto parts = overlap.parts(scene);
    for (const bool delta : {true, false}) {
        const auto scalings = scalings_of(parts, light.scaling.degree, delta);
        if (mixture_text(parts, scalings) != made_for) continue;
        for (size_t n = 0; n < overlap.count; ++n) {
            CollidedLight& own = scene.volumes[overlap.first + n].collided;
            own = light;
            own.scaling = scalings[n];
        }
        return;
    }
    throw UsageError(file.path + ": multiple scattering was computed for the media '" + printable(made_for, 4096) +
                     "', and '" + mixture_text(parts, scalings_of(parts, light.scaling.degree, true)) +
                     "' are asked for: run p1solve again");
}

GridBasePtr overlap_light(app::App& app, const GridFile& file, const Overlap& overlap, const Scene& scene,
                          const Light& light, const TransmittanceOptions& options)
{
    const auto parts = overlap.parts(scene);
    const auto scalings = scalings_in(overlap, scene);
    const GridBasePtr own = grid_of_light(file, light);
    const auto found = own ? read_light(*own, own->getName()) : std::nullopt;
    if (found && same_place(*found, light) && read_periodic(*own) == scene.periodic &&
        get_text(*own, schema::mixture, "") == mixture_text(parts, scalings) &&
        get_text(*own, schema::density_digest, "") == sources_of(parts, nullptr).density)
        return own;
    const auto phase = app.phase("light");
    return app::mixed_light_grid(app, parts, scalings, light, options);
}

}  // namespace vdbcloud
