#pragma once
// The finest level of the multigrid, on blocks. Private to solve/.
#include "vdbcloud/solve/aggregation.h"
#include "vdbcloud/solve/multigrid.h"

namespace vdbcloud {

class FinestLevel {
public:
    explicit FinestLevel(const Stencil&);

    const VoxelGroups& groups() const { return groups_; }
    /// x after smoothing from zero.
    const std::vector<float>& x() const { return x_; }
    size_t bytes() const;

    /// Smooths from zero; what is left of the residual goes to the groups.
    void descend(const std::vector<double>& residual, std::vector<float>& coarse_b);
    /// Adds the groups' correction and smooths; the products are those of Multigrid::cycle.
    Multigrid::Products ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x,
                               const std::vector<double>& against);

private:
    const Stencil& a_;
    VoxelGroups groups_;
    std::vector<float> inverse_, x_, other_;
};

}  // namespace vdbcloud
