#pragma once
// What a run of fractalgen takes, found by a pilot on fewer voxels.
#include "options.h"
#include "plan.h"

namespace vdbcloud::app {

/// Memory of the noise, which a run cannot do without.
Plan least_plan(const Options&, const Domain&);

/// Events and memory of a run. The noise is the same at every size but for its finest waves, so a pilot of a quarter of
/// the voxels along each axis shows which blocks of 8^3 the surface crosses. `mask`: null for a body.
Plan plan_of(const Options&, const Domain&, const FloatGrid* mask);

/// Events of a cloud that was made. `masked`: its envelope is a grid.
Workload work_of(const CloudBlocks&, bool masked);

}  // namespace vdbcloud::app
