#pragma once
// Multigrid on sparse blocks: the preconditioner of conjugate gradients.
#include "vdbcloud/solve/stencil.h"

#include <memory>
#include <vector>

namespace vdbcloud {

/// A fixed linear, symmetric, positive definite approximation of the inverse of a Stencil, in single precision.
///
/// Coarse voxels are 2x2x2 groups of voxels, active where any of the eight is; interpolation is constant on a group.
/// The coarse operator is again a seven-point stencil, with coefficients that know the fine ones: between two groups
/// stand half of each group's inner conductance and the four faces between them, in series,
///
///     1/c = 1/(2 S_inner,A) + 1/S_between + 1/(2 S_inner,B),   S a sum over parallel faces,
///
/// which is the exact coarse conductance for layers in any direction and keeps what connects across jumps.
/// (The plain Galerkin sum would be S_between: twice too stiff already for constant coefficients.) Smoothing is two steps of the Chebyshev iteration of the fourth kind (Lottes 2022) for the
/// spectrum [0, 2] of the Jacobi-scaled matrix, which needs no estimate: a diagonally dominant symmetric matrix never
/// leaves it. Cycles are W where coarse levels are small enough for the work to stay linear, V elsewhere. The
/// coarsest level is solved by Cholesky factors.
///
/// Threads by TBB; values do not depend on their number.
class Multigrid {
public:
    /// `boundary` is the part of extra that stands for conductance to the outside (the rest being absorption): coarse
    /// levels put a group's own resistance before it. Null: all is absorption. `fine` must outlive this.
    explicit Multigrid(const Stencil& fine, const std::vector<float>* boundary = nullptr);
    ~Multigrid();
    Multigrid(Multigrid&&) noexcept;

    /// One cycle from a zero guess; the result stays valid until the next. Values in slots that are not active mean nothing.
    const std::vector<float>& cycle(const std::vector<double>& residual);

    int levels() const;
    /// Memory of everything below the fine stencil.
    size_t bytes() const;

private:
    struct Level;
    void coarsen();
    void visit(size_t level, bool zero_guess);
    std::vector<std::unique_ptr<Level>> levels_;
    struct Coarsest;
    std::unique_ptr<Coarsest> coarsest_;
};

}  // namespace vdbcloud
