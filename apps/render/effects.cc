#include "effects.h"

#include "multiple.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// A layer that each light has is asked for.
bool shows_lights(const RenderOptions& o)
{
    const auto layers = wanted_layers(o);
    return std::any_of(layers.begin(), layers.end(),
                       [](const std::string& name) { return name == "all" || name.rfind("direct", 0) == 0; });
}

bool brings_multiple(const RenderOptions& o, const std::vector<GridFile>& files)
{
    return shows_light_grids(o) && std::any_of(files.begin(), files.end(), [](const GridFile& file) {
               return fluence_grid(file) || find_grid(file, schema::series_phi_name(0));
           });
}

/// The sky whose light is in the picture.
Sky sky_in_play(const RenderOptions& o, const std::vector<GridFile>& files, const LoadedScene& loaded)
{
    const auto background = chosen_background(o, loaded.lights, loaded.up, loaded.sky);
    const Sky lights = lighting_sky(o, loaded, background.light);
    if (!lights.dark()) return lights;
    if (loaded.sky && brings_multiple(o, files)) return *loaded.sky;
    return o.multiple ? app::lighting_sky(o.sky, o.lights, loaded.lights, vector_of(loaded.up)) : Sky();
}

}  // namespace

EffectsAsked checked_effects(const RenderOptions& o)
{
    const EffectsAsked asked = app::effects_asked(o.effects);
    const bool multiple = is_asked(asked, Effect::Multiple);
    if (traces_paths(o) && !multiple)
        throw UsageError("--effects " + printable(o.effects.effects) +
                         " with light paths, which hold all orders of scattering: add multiple, or leave out " +
                         (o.integrator.vertices > 0 ? "--gather" : "--integrator path"));
    o.option.multiple.check_effect(multiple, "multiple among --effects");
    return asked;
}

void end_paths_in_solution(app::App& app, RenderOptions& o, const std::vector<GridFile>& files)
{
    const auto left_out = [](const GridFile& file) { return has_meta(*file.metadata, schema::multiple_left_out); };
    if (o.integrator.vertices == 0 || !std::any_of(files.begin(), files.end(), left_out)) return;
    o.integrator.vertices = 0;
    app.say("p1solve left multiple scattering out: light paths do not end in it, and --gather traces whole paths");
}

Sky lighting_sky(const RenderOptions& o, const LoadedScene& loaded, const Sky& background)
{
    const bool certified = o.option.certify.given();
    Sky sky;
    // A certificate's paths see the sky that was asked for, too, where no file has one.
    if (!shows_light_grids(o) || (certified && !loaded.sky && app::sky_asked(o.sky)))
        sky = chosen_sky(o, loaded.lights, loaded.up, loaded.sky);
    else if ((traces_paths(o) || certified) && loaded.sky)
        sky = *loaded.sky;
    // Solids are lit by the sky that is seen, if no other sky is known.
    if (!loaded.scene.solids.empty() && sky.dark()) sky = loaded.sky ? *loaded.sky : background;
    return sky;
}

Effects effects_of(app::App& app, const RenderOptions& o, const std::vector<GridFile>& files, const LoadedScene& loaded,
                   const std::vector<Solid>& solids, const std::optional<double>& ground)
{
    EffectFacts facts;
    facts.stage = EffectStage::Picture;
    for (const Volume& volume : loaded.scene.volumes)
        facts.media.push_back({volume.density.get(), volume.medium, volume.colour.get(), volume.emission.get(),
                               volume.collided.scaling.delta_f});
    facts.lights = loaded.lights;
    facts.lights_shown = shows_lights(o);
    facts.sky = sky_in_play(o, files, loaded);
    facts.ground_albedo = ground;
    facts.solids = solids;
    facts.walls = o.multiple;
    facts.periodic = loaded.scene.periodic;
    facts.accuracy = app::accuracy_error(o.effects);
    facts.brought = brings_multiple(o, files) || !shows_light_grids(o);
    facts.computed = o.multiple;
    if (files.size() == 1) facts.share = [&] { return share_of_multiple(app, o, loaded); };
    return {facts, app::effects_asked(o.effects)};
}

void apply(const Effects& effects, RenderOptions& o, LoadedScene& loaded)
{
    Scene& scene = loaded.scene;
    scene.lights = effects.lights_in_play(loaded.lights);
    for (Volume& volume : scene.volumes) {
        if (!effects.on(Effect::Emission)) volume.emission = nullptr;
        if (!effects.on(Effect::Tint)) volume.colour = nullptr;
        if (!volume.collided.phi) continue;
        for (const auto& [lit, effect, name] :
             {std::tuple{bool(loaded.sky), Effect::Sky, "sky"}, {bool(scene.ground), Effect::Ground, "ground"}})
            if (lit && effects[effect].left_out)
                throw UsageError("multiple scattering was computed with a " + std::string(name) + ", and --effects " +
                                 printable(o.effects.effects) +
                                 " leaves it out: run p1solve again with these --effects");
    }
    if (!effects.on(Effect::Ground)) {
        scene.ground.reset();
        scene.ground_radiance = nullptr;
    }
    o.integrator.plain_path = !effects.forced();
}

}  // namespace vdbcloud
