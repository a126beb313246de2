#pragma once
// The fast sweep of media that repeat along one or two axes: plane by plane across another. Private to sweep/.
#include "vdbcloud/sweep/transport_sweep.h"

#include <array>
#include <memory>

namespace vdbcloud {

/// reference_sweep() in single precision, for media that repeat. Planes lie across an axis that ends: where two end,
/// for each direction across the one along which it crosses most voxels. All characteristics of a direction begin at
/// one offset from their voxels, which is the same in every plane, so a plane is the plane before it, shifted
/// cyclically: rows of eight voxels at once, eight directions at a time.
///
/// Missing blocks: only those whose voxels others look at, by rays that are found once (void_pieces.h).
///
/// Threads: rows of a plane in parallel; values do not depend on their number.
class PeriodicSweep {
public:
    PeriodicSweep(const VoxelIndex&, const std::vector<SweepFace>&);
    ~PeriodicSweep();

    void run(const SweepSet&, const SweepFields&, SweepResult&, PlaneLight*, SweepGround*);
    size_t bytes() const;

private:
    struct Impl;
    int across(const Vec3d& step) const;
    void finish(const SweepSet&, SweepResult&, PlaneLight*) const;

    const Blocks& blocks_;
    std::array<std::unique_ptr<Impl>, 3> impl_;  // by the axis across the planes; null for axes that repeat
};

}  // namespace vdbcloud
