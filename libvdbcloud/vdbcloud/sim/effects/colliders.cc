// Bodies that air flows around: no air through their surface, and the pressure that this takes (openness.h,
// obstacle_solve.h). Scalars are carried by the same fluxes, so that none enters a body. Their surface is smooth.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

void check(const Parameters& p)
{
    if (p.colliders.empty()) return;
    const auto without = [](bool on, const char* what) {
        if (on) throw InputError(std::string("colliders with ") + what + ": expected one of the two");
    };
    without(!p.momentum, "a given wind (momentum off), which no pressure leads around them");
    without(p.time_scheme == TimeScheme::HugeStep, "huge steps, whose trajectories cross them");
    without(p.viscosity > 0 || p.diffusivity > 0 || p.subgrid, "viscosity, diffusion or sub-grid mixing through their "
                                                               "surface");
    without(p.rain, "rain, which falls through them");
    without(p.frame[0] != 0 || p.frame[1] != 0, "a box that moves over the ground they stand on");
    without(std::isfinite(p.wind_relaxation), "relaxation of the mean wind, which counts the air within them");
    const Surface& s = p.surface;
    without(s.friction_velocity > 0 || s.drag > 0 || s.heat_exchange > 0 || s.water_exchange > 0,
            "the stress and exchange of a surface, which is that of the floor");
    for (const auto& shape : p.colliders)
        if (!shape->body()) throw InputError("collider without a surface: expected a body or a level set");
}

}  // namespace

Effect colliders()
{
    return {"colliders", "open shares and fluxes of faces, conjugate gradients",
            {},          [](const Parameters& p) { return !p.colliders.empty(); },
            check,       [](const Parameters& p) { return 6 + 2 * (1 + !p.lattice.flat(0) + !p.lattice.flat(1)); },
            {},          0,
            "collider"};
}

}  // namespace vdbcloud::sim::effect
