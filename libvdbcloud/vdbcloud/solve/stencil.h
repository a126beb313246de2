#pragma once
// Symmetric seven-point operators on sparse blocks of voxels. Knows coefficients, not what they stand for.
#include "vdbcloud/voxels/blocks.h"

#include <array>
#include <memory>
#include <vector>

namespace vdbcloud {

/// The operator
///
///     (A x)_i = extra_i x_i + sum over the six neighbours j of c_ij (x_i - x_j),   c_ij >= 0, extra_i >= 0
///
/// c_ij between a voxel and the next one up an axis is kept at the lower voxel: face[axis][slot]. Slots that are not
/// active have no coefficients, and fields are undefined there. Constants meet no rounding:
/// A 1 = extra exactly. A copy shares the links c_ij, and has an extra of its own.
struct Stencil {
    explicit Stencil(const Blocks& blocks);

    const Blocks* blocks;
    std::shared_ptr<std::array<std::vector<float>, 3>> links;
    std::array<std::vector<float>, 3>& face;
    std::vector<float> extra;  ///< boundary conductance plus absorption, of the whole voxel

    size_t bytes() const;
};

/// blocks.neighbour(slot, face), without a call within a block.
inline size_t beside(const Blocks& blocks, size_t slot, int face)
{
    constexpr int shift[3] = {6, 3, 0};
    const int axis = face / 2, at = int(slot >> shift[axis]) & 7;
    if (at == (face % 2 ? 7 : 0)) return blocks.neighbour(slot, face);
    return face % 2 ? slot + (size_t(1) << shift[axis]) : slot - (size_t(1) << shift[axis]);
}

/// y = A x in double precision; returns x . y. Threads by TBB; the value does not depend on their number.
double apply(const Stencil&, const std::vector<double>& x, std::vector<double>& y);

/// Sum over all slots of a . b, in double, in a fixed order.
double dot(const Blocks&, const double* a, const double* b);
double sum(const Blocks&, const double* a);
double sum(const Blocks&, const float* a);

}  // namespace vdbcloud
