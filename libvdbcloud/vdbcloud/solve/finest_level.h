#pragma once
// The finest level of the multigrid, on blocks. Private to solve/.
#include "vdbcloud/solve/aggregation.h"

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
    /// Adds the groups' correction and smooths. Returns x . residual.
    double ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x);
    /// x, 0, and a field of that size, 1: what descend() overwrites.
    std::vector<float>& field(int number) { return number == 0 ? x_ : other_; }

private:
    const Stencil& a_;
    VoxelGroups groups_;
    std::vector<float> inverse_, x_, other_;
};

}  // namespace vdbcloud
