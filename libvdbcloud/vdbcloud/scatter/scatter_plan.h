#pragma once
// What scatter_p1() would do and hold, without doing so.
#include "vdbcloud/core/workload.h"
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud {

struct ScatterPlan {
    Workload work;          ///< events of data/unit_costs.txt, as ScatterReport::work counts them
    double bytes = 0;       ///< of all arrays at the peak, the grids of the result included
    double grid_bytes = 0;  ///< of the result's grids
    double leaf_bytes = 0;  ///< of the values of their leaves
    size_t directions = 0;  ///< of a sweep; 0 without sweeps
    double voxels = 0;      ///< of the blocks of 8^3 that hold the medium
};

/// The plan from the medium's blocks and the options. Exact but for the number of the solver's iterations, which grows
/// with the logarithm of the medium's extent; all sweeps of closure.iterations are counted, though they may converge
/// before. `count` false: memory alone, in no time.
ScatterPlan scatter_plan(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         bool count);

/// Iterations that multigrid takes to a tolerance in a medium whose longest side has `extent` voxels.
double expected_iterations(double extent, double tolerance);

}  // namespace vdbcloud
