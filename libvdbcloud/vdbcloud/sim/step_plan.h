#pragma once
// How many steps a simulation would take, without taking them.
#include "vdbcloud/core/workload.h"
#include "vdbcloud/sim/simulation.h"

#include <functional>
#include <optional>
#include <vector>

namespace vdbcloud::sim {

/// Steps up to the last of `times` [s, rising], which steps land on, from time 0. Where limits of the air set the step,
/// the speeds come from a pilot: the same air on 16 to 32 cells along the longest side, for at most 1500 steps. `start`
/// sets the pilot's first air in place of the sounding's and starts it; may be empty.
double expected_steps(const Parameters&, const Sounding&, const std::vector<double>& times,
                      const std::function<void(Simulation&)>& start = {});

/// Events of data/unit_costs.txt of `steps` steps and `frames` frames. `iterations`: of the pressure around colliders,
/// else as many as are usual.
Workload simulation_work(const Parameters&, double steps, double frames, std::optional<double> iterations = {});

}  // namespace vdbcloud::sim
