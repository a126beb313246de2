#pragma once
// Multigrid on sparse blocks: the preconditioner of conjugate gradients.
#include "vdbcloud/solve/graph_level.h"

#include <memory>
#include <vector>

namespace vdbcloud {

/// A fixed linear, symmetric, positive definite approximation of the inverse of a Stencil, in single precision.
///
/// Coarse unknowns are groups of 2x2x2 voxels, split into the parts that are strongly connected: nothing is joined across a
/// void or a jump in the coefficients. Interpolation is constant on a group. Below the finest level, which works on
/// blocks, levels are graphs (graph_level.h). Coarse coefficients know the fine ones: a link between two groups
/// stands in series with half of each group's own conductance along its axis,
///
///     1/c = 1/(2 c_inner,A) + 1/c_between + 1/(2 c_inner,B),    at least c_between / 2,
///
/// summed over the links of a pair; the exact coarse conductance for layers. (The plain Galerkin sum is twice too stiff
/// already for constant coefficients.) Smoothing is two steps of the Chebyshev iteration of the fourth kind (Lottes 2022)
/// for the spectrum [0, 2] of the Jacobi-scaled matrix, which needs no estimate: a diagonally dominant symmetric matrix
/// never leaves it. Cycles are W where coarse levels are small enough, V elsewhere. The coarsest level is solved
/// by Cholesky factors.
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
    struct Finest;
    struct Coarsest;
    void visit(size_t level, bool zero_guess);
    std::unique_ptr<Finest> finest_;
    std::vector<GraphLevel> levels_;  // below the finest
    std::vector<int> visits_;         // of the next level in one visit of each
    std::unique_ptr<Coarsest> coarsest_;
};

}  // namespace vdbcloud
