#pragma once
// Solvers of A x = b on sparse blocks, and how they tell what they did.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/solve/multigrid.h"

#include <vector>

namespace vdbcloud {

struct SolveOptions {
    double tolerance = 1e-6;  ///< of the residual's norm relative to b's, and of the error estimate
    int max_iterations = 200;
    Progress progress;
};

struct SolveResult {
    int iterations = 0;
    bool converged = false;
    double residual = 0;          ///< ||b - A x|| / ||b||
    double error = 0;             ///< estimate of the error in the energy norm, relative to the solution's
    std::vector<double> history;  ///< residual before the first and after each iteration
};

/// Flexible conjugate gradients preconditioned by one multigrid cycle, from the guess in `x` (0 if x is empty).
///
/// `b` is used up: on return it holds the residual. x, the residual and A times a direction are in double precision, as
/// are all sums: where coefficients are large a constant's residual would drown in single-precision rounding;
/// directions are single. Stops when the residual and an estimate of the error, sqrt(r.z / x.b) with z the
/// preconditioned residual, are both below the tolerance: with voids and jumps a small residual alone is no small
/// error. Where nothing absorbs or leaves (extra is 0 everywhere), b and every direction are kept free of constants,
/// and so is x. On return slots that are not active hold 0.
///
/// Not converging is told by the result. Throws Cancelled.
SolveResult conjugate_gradient(const Stencil&, Multigrid&, std::vector<double>& b, std::vector<double>& x,
                               const SolveOptions& = {});

}  // namespace vdbcloud
