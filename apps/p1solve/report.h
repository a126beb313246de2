#pragma once
// The report of p1solve: its own members of --json, and the estimates of --dry-run.
#include "inputs.h"
#include "options.h"
#include "plan.h"

#include "vdbcloud/scatter/voxel_error.h"

namespace vdbcloud {

/// Adds counts and memory to the report, and for each channel the solver's history, energy budget, sweeps and range of
/// phi.
void fill_report(app::App&, const ScatterReport&);

/// Adds the error of the voxels to what bounds the error of the solution, and what it comes from to the report.
void add_voxel_error(app::App&, Accuracy&, const VoxelError&);

/// Memory of a run, and under --dry-run its events. `tint`, `emission`: null for none.
app::Plan plan_of(app::App&, const P1solveOptions&, const app::MediumInput&, const Vec3SGrid* tint,
                  const Vec3SGrid* emission, const std::vector<Light>&);

/// Events of a run that solves nothing.
app::Plan writing_plan(const P1solveOptions&, const app::MediumInput&, const std::vector<Light>&);

/// True if a sky or emission brings light into the medium.
bool glows(const ScatterReport&);

/// Warns of negative fluence, and of emission outside the density, which multiple scattering ignores. Throws
/// ConvergenceError where a solver or the flux limiter missed its tolerance, unless --allow-unconverged.
void check_solution(app::App&, const P1solveOptions&, const Medium&, const ScatterReport&);

}  // namespace vdbcloud
