#pragma once
// Successive over-relaxation: the solver of 1984, for comparison.
#include "vdbcloud/solve/conjugate_gradient.h"

namespace vdbcloud {

/// Solves A x = b by red-black successive over-relaxation with a factor in (0, 2), from the guess in `x` (0 if empty).
///
/// Contract of b, x and the result as for conjugate_gradient, but `error` is not estimated (it stays 0) and only the
/// residual decides: with voids and jumps that is no bound of the error. The residual is evaluated every tenth sweep.
/// Sweeps needed grow with the number of voxels along an edge. Source: Kajiya & Von Herzen 1984, section 4.
SolveResult relax(const Stencil&, double factor, std::vector<double>& b, std::vector<double>& x,
                  const SolveOptions& = {});

}  // namespace vdbcloud
