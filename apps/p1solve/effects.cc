#include "effects.h"

#include "lights.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scatter/expected_share.h"
#include "vdbcloud/scene/panorama.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// What was asked for that only a solution has.
std::string needed_by(const P1solveOptions& o)
{
    for (const auto& [asked, option] : {std::pair{o.series.order > 0, "--series"},
                                        {!o.flux_map.empty(), "--flux-map"},
                                        {o.scatter.heating, "--heating"},
                                        {o.voxel_error, "--voxel-error"}})
        if (asked) return option;
    return "";
}

std::vector<MediumFacts> media_of(const P1Scene& scene)
{
    const app::MediumInput& in = scene.in;
    std::vector<MediumFacts> media;
    for (const MediumPart& part : in.parts) media.push_back({part.density.get(), part.medium, part.colour.get()});
    if (media.empty()) media.push_back({in.density.get(), in.medium, scene.tint.get()});
    media.front().emission = scene.emission.get();
    return media;
}

/// True if the light's grid is in the file and 0 everywhere. By way of a ground, or of solids that
/// send light, the light may still reach the medium.
bool is_hidden(const P1solveOptions& o, const P1Scene& scene, const Light& light)
{
    if (scene.solids.empty() || o.ground.given() || o.scatter.closure.iterations > 0 ||
        !has_light(scene.in, light, o.scatter.solids))
        return false;
    const GridBasePtr grid = grid_of_light(scene.in.file, light);
    const auto dark = [](const auto& values) {
        for (auto v = values.cbeginValueOn(); v; ++v)
            if (*v != std::decay_t<decltype(*v)>(0.0f)) return false;
        return true;
    };
    if (const auto grey = openvdb::gridPtrCast<FloatGrid>(grid)) return dark(*grey);
    if (const auto coloured = openvdb::gridPtrCast<Vec3SGrid>(grid)) return dark(*coloured);
    return false;
}

ShareFound share_of(app::App& app, const P1solveOptions& o, const P1Scene& scene)
{
    const auto phase = app.phase("expected share");
    ShareOptions options;
    options.periodic = scene.in.periodic;
    options.enough = app::accuracy_error(o.effects);
    options.error = std::min(options.error, std::max(1e-5, options.enough / 8));
    std::vector<Light> lights;
    for (const Light& light : scene.lights)
        if (!is_hidden(o, scene, light)) lights.push_back(light);
    const ExpectedShare found =
        expected_share(*scene.in.density, scene.tint.get(), scene.in.medium, lights, Sky(), options);
    return {found.share, found.error};
}

}  // namespace

Effects effects_of(app::App& app, const P1solveOptions& o, const P1Scene& scene)
{
    EffectFacts facts;
    facts.stage = EffectStage::Scatter;
    facts.media = media_of(scene);
    facts.lights = scene.lights;
    for (const Light& light : scene.lights) facts.hidden.push_back(is_hidden(o, scene, light));
    facts.sky = scene.sky;
    if (o.ground.given()) facts.ground_albedo = o.ground_albedo;
    facts.solids = scene.solids;
    facts.walls = o.scatter.closure.iterations > 0;
    facts.periodic = scene.in.periodic;
    facts.accuracy = app::accuracy_error(o.effects);
    facts.needed_by = needed_by(o);
    if (scene.in.parts.empty()) facts.share = [&] { return share_of(app, o, scene); };
    return {facts, app::effects_asked(o.effects)};
}

void apply(const Effects& effects, P1Scene& scene, P1solveOptions& o)
{
    const std::vector<Light> all = scene.lights;
    scene.lights = effects.lights_in_play(all);
    for (size_t n = 0; n < all.size(); ++n)
        if (!effects.lights()[n] && is_asked(app::effects_asked(o.effects), Effect::Lights))
            o.scatter.hidden_lights.push_back(all[n]);
    if (!effects.on(Effect::Emission)) scene.emission = nullptr;
    if (!effects.on(Effect::Tint)) scene.tint = nullptr;
    for (MediumPart& part : o.scatter.parts)
        if (!effects.on(Effect::Tint)) part.colour = nullptr;
    o.scatter.sky = effects.on(Effect::Sky) ? scene.sky : Sky();
    if (!effects.on(Effect::Ground)) o.scatter.ground_albedo.reset();
    o.scatter.channels_apart = effects.forced();
}

void leave_out_multiple(app::App& app, const Effects& effects, GridFile& file)
{
    put_collided_light(file, {});
    put_panorama(file, nullptr);
    remove_grids(file, [](const std::string& name) {
        return schema::has_role(name, schema::Role::Heating) || schema::has_role(name, schema::Role::GroundRadiance) ||
               schema::has_role(name, schema::Role::SeriesFluence) || schema::has_role(name, schema::Role::SeriesOrder);
    });
    set_number(*file.metadata, schema::multiple_left_out, effects.share() ? effects.share()->share : 0);
    app.say("multiple scattering is left out, and no phi is written: " + effects[Effect::Multiple].why);
}

}  // namespace vdbcloud
