#pragma once
// The light of the frame before as the start of a solve.
#include "vdbcloud/optics/collided_light.h"

#include <memory>
#include <string>

namespace vdbcloud {

/// The collided light of an earlier solve, and how its medium has moved since.
struct PreviousLight {
    CollidedLight light;
    Vec3SGridPtr velocity;  ///< of the medium now [world unit/s]; null: at rest
    double seconds = 0;     ///< since then
    std::string digest;     ///< grid_digest() of its phi, for the metadata of what starts from it
};

class VoxelIndex;

/// Moments of collided light at the slots of an index, about its axes, of one channel: degree 0 is phi / sqrt(4 pi).
struct StartingLight {
    std::vector<char> known;                  ///< by slot: the earlier medium was there
    std::vector<std::vector<float>> moments;  ///< by harmonic, up to the last degree that the earlier light has
};

/// The light of PreviousLight where the voxels of an index have come from: trilinear samples at x - seconds x
/// velocity(x) for a voxel's centre x, which errs by O(seconds^2) of the acceleration. Voxels from without the earlier
/// medium are not known. Threads: all of TBB's, with equal results.
StartingLight starting_light(const PreviousLight&, const VoxelIndex&, int channel, int degree);

}  // namespace vdbcloud
