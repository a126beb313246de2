#pragma once
// What p1solve tells of a run: the parts of --json that are its own, and what --dry-run expects.
#include "options.h"

namespace vdbcloud {

/// Counts, memory, and of each channel the solver's history, the energy budget, sweeps and the range of phi.
void fill_report(app::App&, const ScatterReport&);

/// Says, and reports, memory and processor seconds that a run would take. Both come from counts of voxels and from
/// costs a voxel as the benchmarks measured them, within a factor of two.
void estimate(app::App&, const P1solveOptions&, const Medium&, const FloatGrid& density, size_t lights);

/// Warns of negative fluence and of emission that is left out. Throws ConvergenceError where a solver or the flux
/// limiter missed its tolerance, unless --allow-unconverged.
void check_solution(app::App&, const P1solveOptions&, const Medium&, const ScatterReport&);

}  // namespace vdbcloud
