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

    /// Smooths from x = 0; coarse_b becomes the new residual, summed over groups.
    void descend(const std::vector<double>& residual, std::vector<float>& coarse_b);
    /// Adds the groups' correction and smooths. Returns the products of Multigrid::cycle.
    Multigrid::Products ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x,
                               const std::vector<double>& against);

private:
    const Stencil& a_;
    VoxelGroups groups_;
    std::vector<float> inverse_, x_, other_;
};

}  // namespace vdbcloud
