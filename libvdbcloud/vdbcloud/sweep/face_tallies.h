#pragma once
// Radiance on the faces of a cloud, summed over directions. Private to sweep/.
#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

/// Sums of FaceTally for a list of faces, block by block and side by side, so that one direction takes all of a side
/// alike. Threads: add() to different blocks.
class FaceTallies {
public:
    /// `outward_only`: leaves out light that comes in through a face.
    FaceTallies(size_t blocks, const std::vector<SweepFace>& faces, bool outward_only = false);

    void clear();
    /// Radiance of direction d of the batch on the block's faces, times the weight. `direction` is unit, by axis.
    /// `sums`, if given: what FaceTally::current of all faces across each axis gets, for light that goes out.
    void add(const block_sweep::Traversal&, int d, size_t block, const Vec3d& direction, float weight,
             const block_sweep::Scratch&, std::array<double, 3>* sums = nullptr);
    bool any(size_t block) const { return begin_[block * 6] != begin_[block * 6 + 6]; }
    /// In the order of the list.
    void write(std::vector<FaceTally>& to) const;
    size_t bytes() const;

private:
    bool outward_only_;
    std::vector<uint32_t> begin_;            // of each side of each block, and the end
    std::vector<uint32_t> number_;           // in the list
    std::vector<uint16_t> slot_;             // in the block
    std::array<std::vector<float>, 3> sum_;  // current, fluence, second
};

}  // namespace vdbcloud
