#pragma once
// Where the rays of a whole missing block end, in few pieces. Private to sweep/.
#include "vdbcloud/sweep/void_rays.h"

#include <array>

namespace vdbcloud {

/// A box of voxels of a missing block whose rays all end on one face of one block, or all outside.
struct VoidPiece {
    int32_t block;  ///< -1: outside
    uint8_t axes;   ///< of the face, as VoidRays::Hit; more than one for a single voxel alone
    std::array<uint8_t, 3> lo, hi;
    std::array<double, 3> at;  ///< where the ray of voxel `lo` ends, as VoidRays::Hit
};

/// How the component `a` of VoidPiece::at moves when a ray's start moves by one voxel along `along`, on a face across
/// `axis`.
inline double void_slope(const Vec3d& step, int axis, int a, int along)
{
    if (a == axis) return 0;
    return a == along ? 1 : along == axis ? -step[a] / step[axis] : 0;
}

/// Finds the pieces of missing blocks. Holds scratch memory: one object per thread.
class VoidPieces {
public:
    explicit VoidPieces(const VoidRays& rays) : rays_(rays), hits_(512), traced_(512) {}

    using Corner = std::array<int, 3>;
    /// Appends the pieces of the voxels lo .. hi of the block at `at` for rays against `step`.
    ///
    /// Rays are parallel, and a block is a box of the same shape as the voxels of a missing block and larger, so a
    /// block that stops one ray stops the ray of a corner, too. Where the corners' rays end on one face, or all
    /// outside, so do all rays between them. A block that repeats is one where the rays meet the same copy.
    void find(const Vec3i& at, const Corner& lo, const Corner& hi, const Vec3d& step, std::vector<VoidPiece>& to);

private:
    const VoidRays::Hit& trace(const Corner&);
    void split(const Corner& lo, const Corner& hi, std::vector<VoidPiece>& to);

    const VoidRays& rays_;
    Vec3d origin_{0, 0, 0}, step_{0, 0, 0};
    std::vector<VoidRays::Hit> hits_;
    std::vector<char> traced_;
};

}  // namespace vdbcloud
