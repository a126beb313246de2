#pragma once
// Detail below the voxels of a simulation: noise that moves with the flow and conserves water.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/core/progress.h"

#include <cstdint>

namespace vdbcloud {

struct DetailOptions {
    int factor = 4;      ///< voxels of the result along an edge of a coarse voxel, 2..8
    double amount = 1;   ///< standard deviation of the logarithm of density where matter ends, 0..3
    double period = 60;  ///< life of a pattern of the noise [s]
    double time = 0;     ///< of the frame [s]
    uint64_t seed = 1;
};

/// A density on voxels that are `factor` times finer along each axis,
///
///     d(x) = c(x) exp(a(x) n(x, t)) k(x)
///
/// * c is trilinear between coarse voxels, of values whose mean over a coarse voxel is its own, and falls to 0 on the
///   faces that it shares with voids: it has no jump.
/// * n is normal noise of variance 1 whose waves are shorter than two coarse voxels, Kolmogorov's spectrum beyond. It
///   moves with the flow: two patterns N of random place, each of which lives for `period` and is taken at
///   x - v(x) (age - period / 2); their weights 1 - |2 age / period - 1| fall to 0 where a pattern begins and ends, half
///   a period apart, and the sum of their squares is made 1. From t to t + dt the noise of a fluid at rest changes by
///   2 sin(dtheta / 2) in the root mean square, theta = atan2 of the weights: 2 sqrt(2) dt / period on the average.
///   (Neyret, Advected Textures, SCA 2003: regenerated phases; Max, Crawfis, Williams 1992: their blending.)
/// * a is `amount` where matter ends or jumps, and falls to 0.15 of it in even matter: the greatest difference from a
///   neighbour over the larger of the two.
/// * k is 1 but for what keeps the mean over each coarse voxel: water is conserved there, to rounding. It is trilinear
///   between coarse voxels up to a last small part.
///
/// Where a coarse voxel is 0 or inactive the result is 0. `velocity` [world unit/s], staggered or not, on any lattice;
/// null: at rest. Frames do not depend on each other. Values do not depend on threads or on where the tree has tiles.
///
/// Cost: active coarse voxels times factor^3; memory: the result, and 8 MB. Throws InputError for a transform that is
/// not affine, for tiles of more than 2^24 coarse voxels, and Cancelled.
FloatGridPtr add_detail(const FloatGrid& coarse, const Vec3SGrid* velocity, const DetailOptions&, const Progress& = {});

}  // namespace vdbcloud
