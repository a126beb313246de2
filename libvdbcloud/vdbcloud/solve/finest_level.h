#pragma once
// The finest level of the multigrid, on blocks. Private to solve/.
#include "vdbcloud/solve/aggregation.h"

#include <memory>

namespace vdbcloud {

class FinestLevel {
public:
    explicit FinestLevel(const Stencil&);
    /// The groups of `like`, whose stencil has the same links. The two share groups and fields.
    FinestLevel(const Stencil&, const FinestLevel& like);

    /// Before the first descend(): the fields, which the making of coarser levels does not need.
    void make_fields();
    const VoxelGroups& groups() const { return *groups_; }
    /// Extra of the groups, given that of the groups of `like`.
    std::vector<float> next_extra(const FinestLevel& like, std::vector<float> extra) const;
    /// x after smoothing from zero.
    const std::vector<float>& x() const { return fields_->x; }
    size_t bytes() const;

    /// Smooths from x = 0; coarse_b becomes the new residual, summed over groups.
    void descend(const std::vector<double>& residual, std::vector<float>& coarse_b);
    /// Adds the groups' correction and smooths. Returns x . residual.
    double ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x);
    /// x, 0, and a field of that size, 1: what descend() overwrites.
    std::vector<float>& field(int number) { return number == 0 ? fields_->x : fields_->other; }

private:
    struct Fields {
        std::vector<float> x, other;
    };
    const Stencil& a_;
    std::shared_ptr<const VoxelGroups> groups_;
    std::shared_ptr<Fields> fields_;
    bool owns_ = true;
};

}  // namespace vdbcloud
