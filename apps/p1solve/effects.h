#pragma once
// Which effects p1solve has in play, and what is left of the input for the solution.
#include "inputs.h"
#include "options.h"

#include <memory>
#include <vector>

namespace vdbcloud {

/// What a scene of p1solve has, all of it.
struct P1Scene {
    app::MediumInput& in;
    std::vector<Light> lights;
    std::vector<Solid> solids;
    Sky sky;
    Vec3SGridPtr tint, emission;  ///< Cd and emission of `in`; may be null
};

/// The effects in play. Estimates the share of multiple scattering where that decides. Calls for lights whose grids are
/// in the file.
Effects effects_of(app::App&, const P1solveOptions&, const P1Scene&);

/// Takes out of the scene and of ScatterOptions what is not in play.
void apply(const Effects&, P1Scene&, P1solveOptions&);

/// Without multiple scattering: takes an earlier solution out of the file, notes in the file that and how much of the
/// light is left out, and says so.
void leave_out_multiple(app::App&, const Effects&, GridFile&);

}  // namespace vdbcloud
