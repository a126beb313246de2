#include "lights.h"

#include "scaled_light.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/mixture.h"

#include <algorithm>
#include <set>
#include <string>

namespace vdbcloud {

bool has_light(const app::MediumInput& in, const Light& light, const std::vector<Solid>& solids)
{
    if (!in.parts.empty()) return false;  // a joined file brings no light
    const GridBasePtr there = grid_of_light(in.file, light);
    const auto theirs = there ? read_light(*there, there->getName()) : std::nullopt;
    return theirs && same_light(*theirs, light) && app::same_extinction(*there, in.medium) &&
           read_periodic(*there) == in.periodic &&
           get_text(*there, schema::solids, "") == solids_digest(solids, /*materials=*/false) &&
           get_text(*there, schema::density_digest, "") == grid_digest(*in.density);
}

bool adds_nothing(const EffectsAsked& asked, const Light& light)
{
    return !is_asked(asked, Effect::Lights) ||
           (asked.mode != EffectsAsked::Mode::All && light.strength() == Vec3d(0.0));
}

/// Removes the grids of lights that are not those of the solution: later stages would take them for its lights.
void drop_other_lights(app::App& app, GridFile& file, const std::vector<Light>& lights)
{
    std::set<std::string> own;
    for (const Light& light : lights)
        if (const GridBasePtr grid = grid_of_light(file, light)) own.insert(grid->getName());
    for (const Light& theirs : lights_of(file)) {
        const std::string of = transmittance_name(theirs);
        if (own.count(of) > 0) continue;
        app.say("the " + app::described(theirs) + " of the input is none of this solution: '" + of +
                "' is not written");
        remove_grids(file, [&](const std::string& name) { return name == of; });
    }
}

std::vector<Light> lights_for(app::App& app, const P1solveOptions& o, app::MediumInput& in)
{
    GridFile& file = in.file;
    const FloatGrid& density = *in.density;
    const Medium& medium = in.medium;
    const UpAxis up = app::settled_up(app, o.up, file, o.lights.by_atmosphere || o.lights.environment.asked());
    auto lights = app::lights_asked(o.lights, vector_of(up));
    if (lights.empty()) lights = app::inherited_lights(in.lights);
    const bool glow = in.fire.heat() || find_grid(file, schema::emission);
    if (lights.empty() && !app::sky_asked(o.sky) && !glow) {
        lights.push_back(app::automatic_sun(vector_of(app::settled_up(app, o.up, file, true))));
        app.say("no light asked for: a " + app::described(lights[0]));
    }
    const EffectsAsked effects = app::effects_asked(o.effects);
    for (const Light& light : lights) {
        app.uses(transmittance_name(light));
        if (app.dry_run()) continue;
        if (adds_nothing(effects, light)) {
            const auto is_it = [&](const Light& theirs) { return same_light(theirs, light); };
            const auto all = lights_of(file);
            if (std::none_of(all.begin(), all.end(), is_it)) put_grid(file, unlit_grid(density, light));
            continue;
        }
        if (has_light(in, light, o.scatter.solids)) continue;
        const auto phase = app.phase(transmittance_name(light));
        TransmittanceOptions accuracy;
        accuracy.disc_samples = o.scatter.disc_samples;
        accuracy.periodic = in.periodic;
        accuracy.solids = o.scatter.solids;
        put_grid(file, in.parts.empty()
                           ? transmittance_grid(density, medium, light, accuracy, app.progress(light.name))
                           : app::mixed_light_grid(app, in.parts, scalings_of(in.parts, 1, false), light, accuracy));
    }
    drop_other_lights(app, file, lights);
    return lights;
}

}  // namespace vdbcloud
