#pragma once
// What scatter_p1() would do and hold, without doing so.
#include "vdbcloud/core/workload.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud {

struct ScatterPlan {
    Workload work;           ///< events of data/unit_costs.txt, as ScatterReport::work counts them
    double bytes = 0;        ///< of all arrays at the peak, the grids of the result included
    double grid_bytes = 0;   ///< of the result's grids
    double value_bytes = 0;  ///< of their values, as files store them
    size_t directions = 0;   ///< of a sweep; 0 without sweeps
    double voxels = 0;       ///< of the blocks of 8^3 that hold the medium
};

/// The plan from the medium's blocks and the options. Exact but for the number of the solver's iterations, which grows
/// with the logarithm of the medium's extent; all sweeps of closure.iterations are counted, though they may converge
/// before. `count` false: memory alone, in no time. Throws InputError as the solution does, see check_voxels().
ScatterPlan scatter_plan(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         bool count);

/// Blocks of 8^3 voxels of a density, tiles included.
double blocks_of(const FloatGrid& density);

/// Nodes of a grid of results, which has the voxels of a density and their fringe: leaves as around a compact body.
TreeSize fringed_size(const FloatGrid& density);

/// Iterations that multigrid takes to a tolerance in a medium whose longest side has `extent` voxels.
double expected_iterations(double extent, double tolerance);

/// Sweeps that successive over-relaxation with `factor` takes, of Young's theory for a box of `extent` voxels along an
/// edge (Young, Iterative Solution of Large Linear Systems, 1971, section 6.2).
double expected_relaxation(double extent, double factor, double tolerance);

}  // namespace vdbcloud
