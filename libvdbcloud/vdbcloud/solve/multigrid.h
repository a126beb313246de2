#pragma once
// Multigrid on sparse blocks: the preconditioner of conjugate gradients.
#include "vdbcloud/solve/stencil.h"

#include <memory>
#include <vector>

namespace vdbcloud {

/// An approximation of the inverse of a Stencil, in single precision, for conjugate gradients.
///
/// Coarse unknowns are groups of strongly connected ones (aggregation.h): nothing is joined across a void or a jump of
/// the coefficients, so their size does not matter. Interpolation is constant on a group and coarse operators are
/// Galerkin's, sums of fine links, hence symmetric positive definite in any medium. They are twice too stiff for smooth
/// errors, which the K cycle compensates (Notay & Vassilevski 2008, Recursive Krylov-based multigrid cycles): each
/// coarse level is solved by one or two steps of flexible conjugate gradients preconditioned by the next level.
/// Smoothing is two Chebyshev steps (chebyshev.h) before and after the coarse correction on the finest level, which
/// works on blocks, and after it on the levels below, which are graphs: their Krylov steps need no symmetric
/// preconditioner, and smoothing there before the correction saves half an iteration for two fifths of the products.
/// The coarsest level is solved by Cholesky factors.
///
/// Threads by TBB; values do not depend on their number.
class Multigrid {
public:
    /// `fine` must outlive this.
    explicit Multigrid(const Stencil& fine);
    /// With the groups of `like`, whose stencil has the same links and nowhere a larger extra: what extra alone holds
    /// there is held here. The two share all but extra and vectors of coarse levels, and the fields of the finest
    /// level, so one of them works at a time. Costs a tenth of a hierarchy of its own.
    Multigrid(const Stencil& fine, const Multigrid& like);
    ~Multigrid();
    Multigrid(Multigrid&&) noexcept;

    /// z, one cycle from a zero guess; returns z . residual. z() stays valid until the next cycle. Values at inactive
    /// slots are undefined.
    double cycle(const std::vector<double>& residual);
    const std::vector<float>& z() const;
    /// Two fields of slots() values that the next cycle overwrites, 0 and 1; the first is z().
    std::vector<float>& scratch(int);

    /// Unknowns of each level, the finest first.
    std::vector<size_t> sizes() const;
    int levels() const;
    /// Memory of everything but the fine stencil.
    size_t bytes() const;

private:
    struct Levels;
    std::unique_ptr<Levels> levels_;
};

}  // namespace vdbcloud
