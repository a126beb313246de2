#pragma once
// How unknowns are grouped for the next coarser level: only where a constant on the group is a good guess. Private to
// solve/.
#include "vdbcloud/solve/graph.h"
#include "vdbcloud/solve/stencil.h"

namespace vdbcloud {

/// Groups of voxels within 2x2x2 of each other that strong links connect: those of at least 0.4 of the strongest link
/// of either end, so that nothing is joined across a void or a jump of the coefficients. Voxels that their extra alone
/// holds (a third of their links or more) need no coarse correction and get no group. Numbered block by block.
struct VoxelGroups {
    static constexpr uint16_t none = 0xffff;
    std::vector<uint16_t> of;    ///< for each slot its group, counted from its block's first; none without one
    std::vector<int32_t> first;  ///< group of each block; the last entry is the number of all

    size_t count() const { return size_t(first.back()); }
    int32_t operator()(size_t slot) const { return of[slot] == none ? -1 : first[slot / Blocks::size] + of[slot]; }
    size_t bytes() const { return 2 * of.size() + 4 * first.size(); }
};
VoxelGroups group_voxels(const Stencil&);

/// The Galerkin operator on the groups (graph.h).
Graph collapsed(const Stencil&, const VoxelGroups&);

/// Groups of a graph's unknowns by three rounds of pairing, each unknown with the unpaired neighbour of lowest
/// condition number. Two sets are joined if
///
///     2 m_I m_J / (m_I + m_J)  <=  9 (c_IJ + e_I e_J / (e_I + e_J)),
///
/// m the sum of the diagonal, c the links between them, e the sum of extra: on a pair of unknowns the left by the right
/// without the 9 bounds the condition number of the two-level method (Napov & Notay 2012, An algebraic multigrid method
/// with guaranteed convergence rate, SIAM J. Sci. Comput. 34). What is weakly linked from both sides stays apart; a
/// dense voxel, whose links are all weak to its neighbours, may follow one of them. `group` takes the group of each
/// unknown, -1 of what extra holds. Returns the Galerkin operator.
Graph grouped(const Graph& fine, std::vector<int32_t>& group);

}  // namespace vdbcloud
