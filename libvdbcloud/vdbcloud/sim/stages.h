#pragma once
// The stages of a step. Private to sim/.
#include "vdbcloud/sim/parameters.h"

#include <vector>

namespace vdbcloud::sim {

/// One stage of a step of length 1: reads a[in], writes a[out] = scalar or momentum formula of rows.h with x0 = a[0],
/// x1 = a[x1], x = a[in].
struct Stage {
    int in, x1, out;
    double time_in, time_x1, time_out;  // where these are, as fractions of the step
    double alpha, beta, tau;            // ScalarStage of a step of length 1
    double weight;                      // of this stage's tendency in the whole step
};
const std::vector<Stage>& stages(TimeScheme);

}  // namespace vdbcloud::sim
