#pragma once
// The sum of sparse grids on one lattice. Private to optics/.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// One grid of a sum.
template<typename GridT>
struct Summand {
    std::shared_ptr<const GridT> grid;
    double scale;      ///< factor of the grid's values
    std::string name;  ///< for messages
};

/// The number of the summand whose voxels have the least volume, the first one of equals.
template<typename GridT>
size_t finest(const std::vector<Summand<GridT>>&);

/// The sum of scale x grid over all summands, on the lattice of `to`: active where any summand is, inactive values 0.
/// Where the voxels of a summand coincide with those of `to`, values move from voxel to voxel and tiles stay tiles.
/// Elsewhere the trilinear interpolant is sampled at the voxel centres of `to` and made sparse again.
///
/// `kept`: a further factor for each summand. If empty, it is set to the factors that keep the integral of each summand
/// over space; they are exactly 1 where voxels coincide.
///
/// Throws UsageError that names a summand if a voxel of `to` is longer than a voxel of the summand along one of the
/// summand's axes: samples would then miss values; if samples are more than 2^28; or if an index of `to` would be
/// beyond 2^30.
template<typename GridT>
std::shared_ptr<GridT> sum_on_lattice(const std::vector<Summand<GridT>>&, const Transform& to,
                                      std::vector<double>& kept);

}  // namespace vdbcloud
