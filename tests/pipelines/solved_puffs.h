#pragma once
// The cloud of puffs with its light: the scene of the standing cases of accuracy.
#include "vdbcloud/render/integrator.h"

namespace vdbcloud::test {

/// The cloud of puffs at a vertical optical depth, with a sun, transmittance, and a solution of P1 and `iterations`
/// sweeps.
Scene solved_puffs(double tau, double w0, double g, int iterations);

}  // namespace vdbcloud::test
