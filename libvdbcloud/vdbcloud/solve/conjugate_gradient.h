#pragma once
// Solvers of A x = b on sparse blocks, and their report.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/solve/multigrid.h"

#include <vector>

namespace vdbcloud {

struct SolveOptions {
    double tolerance = 1e-6;  ///< of the residual's norm relative to b's, and of the error estimate
    /// The residual is relative to this norm where it is below b's; 0: to b's. At least 1e-9 of b's is taken: rounding
    /// leaves no less.
    double norm = 0;
    int max_iterations = 200;
    Progress progress;
};

struct SolveResult {
    int iterations = 0;
    bool converged = false;
    double residual = 0;          ///< ||b - A x|| / ||b||, or over SolveOptions::norm
    double error = 0;             ///< estimate of the error in the energy norm, relative to the solution's
    std::vector<double> history;  ///< residual before the first and after each iteration
};

/// Conjugate gradients preconditioned by one multigrid cycle, from the guess in `x` (0 if x is empty).
///
/// `b` is overwritten with the residual b - A x. x, the residual and A times a direction are in double precision, as
/// are all sums: where coefficients are large, single-precision rounding exceeds a constant's residual; directions are
/// single. Stops when the residual and an estimate of the error, sqrt(r.z / x.b) with z the preconditioned residual,
/// are both below the tolerance: among voids and jumps a small residual alone does not bound the error. Where nothing
/// absorbs or leaves (extra is 0 everywhere), the mean over active slots is removed from b, from every direction and
/// from x. On return inactive slots hold 0.
///
/// Failure to converge is in the result. Throws Cancelled.
SolveResult conjugate_gradient(const Stencil&, Multigrid&, std::vector<double>& b, std::vector<double>& x,
                               const SolveOptions& = {});

}  // namespace vdbcloud
