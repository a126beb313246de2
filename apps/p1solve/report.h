#pragma once
// The report of p1solve: its own members of --json, and the estimates of --dry-run.
#include "options.h"

namespace vdbcloud {

/// Adds counts and memory to the report, and for each channel the solver's history, energy budget, sweeps and range of
/// phi.
void fill_report(app::App&, const ScatterReport&);

/// Estimates memory and processor seconds of a run, within a factor of two: from the numbers of voxels and from costs
/// per voxel that the benchmarks measured. `emission`: null for none.
void estimate(app::App&, const P1solveOptions&, const Medium&, const FloatGrid& density, const Vec3SGrid* emission,
              size_t lights);

/// True if a sky or emission brings light into the medium.
bool glows(const ScatterReport&);

/// Warns of negative fluence, and of emission outside the density, which multiple scattering ignores. Throws
/// ConvergenceError where a solver or the flux limiter missed its tolerance, unless --allow-unconverged.
void check_solution(app::App&, const P1solveOptions&, const Medium&, const ScatterReport&);

}  // namespace vdbcloud
