#pragma once
// The coarse levels of the multigrid: graphs of groups of voxels, joined only where they are strongly connected. Private to solve/.
#include "vdbcloud/solve/stencil.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// A symmetric operator (A x)_i = extra_i x_i + sum_j c_ij (x_i - x_j) on unknowns with integer places, row by row.
struct GraphLevel {
    std::vector<uint32_t> begin;      ///< of each row in column and c; one more than there are unknowns
    std::vector<int32_t> column;
    std::vector<float> c;
    std::vector<float> extra, inverse;  ///< inverse of the diagonal, 0 where there is none
    std::vector<float> boundary;      ///< part of extra that is conductance to the outside; empty once the hierarchy is made
    std::vector<Vec3i> place;         ///< empty once the hierarchy is made
    std::vector<int32_t> parent;      ///< unknown of the next level
    std::vector<float> b, x, other;

    size_t size() const { return extra.size(); }
    size_t bytes() const;

    /// Both Chebyshev steps on x (multigrid.h); from a zero guess if asked.
    void smooth(bool zero_guess);
    /// other = b - A x
    void residual();
};

/// Groups of 2x2x2 voxels, split into their strongly connected parts; `parent` takes the unknown of each active slot.
GraphLevel coarse_level(const Stencil& fine, const std::vector<float>& boundary, std::vector<int32_t>& parent);
/// The same of a level below, whose parent it fills.
GraphLevel coarse_level(GraphLevel& fine);

}  // namespace vdbcloud
