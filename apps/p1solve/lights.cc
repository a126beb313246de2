#include "lights.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/light/transmittance_grid.h"

namespace vdbcloud {

bool has_light(const app::MediumInput& in, const Light& light)
{
    const GridBasePtr there = grid_of_light(in.file, light);
    const auto theirs = there ? read_light(*there, there->getName()) : std::nullopt;
    return theirs && same_light(*theirs, light) && app::same_extinction(*there, in.medium) &&
           read_periodic(*there) == in.periodic &&
           get_text(*there, schema::density_digest, "") == grid_digest(*in.density);
}

std::vector<Light> lights_for(app::App& app, const P1solveOptions& o, app::MediumInput& in)
{
    GridFile& file = in.file;
    const FloatGrid& density = *in.density;
    const Medium& medium = in.medium;
    auto lights = app::lights_asked(o.lights);
    if (lights.empty()) lights = app::inherited_lights(in.lights);
    const bool glow = bool(find_grid(file, schema::emission));
    if (lights.empty() && !sky_wanted(o) && !glow) {
        lights.push_back(app::automatic_sun(vector_of(app::settled_up(app, o.up, file, true))));
        app.say("no light asked for: a " + app::described(lights[0]));
    }
    for (const Light& light : lights) {
        app.uses(transmittance_name(light));
        if (app.dry_run()) continue;
        if (has_light(in, light)) continue;
        const auto phase = app.phase(transmittance_name(light));
        TransmittanceOptions accuracy;
        accuracy.disc_samples = o.scatter.disc_samples;
        accuracy.periodic = in.periodic;
        put_grid(file, transmittance_grid(density, medium, light, accuracy, app.progress(light.name)));
    }
    return lights;
}

}  // namespace vdbcloud
