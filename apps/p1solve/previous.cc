#include "previous.h"

#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/sources.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// From the times that cloudsim writes; 0 where one of the files has none.
double seconds_between(const MetaMap& then, const MetaMap& now)
{
    if (!has_meta(then, schema::sim_time) || !has_meta(now, schema::sim_time)) return 0;
    return get_number(now, schema::sim_time, 0) - get_number(then, schema::sim_time, 0);
}

}  // namespace

void choose_start(app::App& app, P1solveOptions& o, const app::MediumInput& in)
{
    if (o.start_from.empty()) return;
    const GridFile file = app.read(o.start_from);
    auto previous = std::make_shared<PreviousLight>();
    const std::string name = printable(o.start_from, 4096);
    app::of_file(o.start_from, [&] {
        previous->light = read_collided_light(file, in.medium.phase, app.warnings());
        if (!previous->light.phi)
            throw InputError("no multiple scattering: expected a file of p1solve, or leave out --start-from");
        if (read_periodic(*previous->light.phi) != in.periodic)
            throw UsageError(name + " is of a medium periodic along " +
                             periodic_text(read_periodic(*previous->light.phi)) + ", and this one along " +
                             periodic_text(in.periodic) + ": leave out --start-from");
    });
    const double ours = delta_scaling(in.medium.phase, o.scatter.closure.degree).delta_f;
    const double f = o.scatter.delta && in.parts.empty() ? ours : previous->light.scaling.delta_f;
    if (std::abs(previous->light.scaling.delta_f - f) > 1e-6)
        throw UsageError(name + " was solved with another phase function or --degree: its light is scaled by f = " +
                         app::brief(previous->light.scaling.delta_f) + ", and this by " + app::brief(f));
    previous->velocity = app::vector_grid(app, in.file, grid_of(in.file, schema::velocity));
    o.start_seconds_option.check_effect(bool(previous->velocity), "an input with a grid vel");
    previous->seconds =
        o.start_seconds_option.given() ? o.start_seconds : seconds_between(*file.metadata, *in.file.metadata);
    previous->digest = grid_digest(*fluence(previous->light));
    o.scatter.previous = std::move(previous);
}

void place_start(P1solveOptions& frame, const app::App::PlaceFrame& place, std::string& last)
{
    if (frame.start_from.empty()) return;
    std::string now = frame.start_from;
    place(now);
    if (now == frame.start_from) return;  // one file for all
    frame.start_from = last;
    last = now;
}

}  // namespace vdbcloud
