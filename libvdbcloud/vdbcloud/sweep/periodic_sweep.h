#pragma once
// The fast sweep of media that repeat along two axes: plane by plane across the third. Private to sweep/.
#include "vdbcloud/sweep/transport_sweep.h"

#include <memory>

namespace vdbcloud {

/// reference_sweep() in single precision, for layers. All characteristics of a direction begin at one offset from their
/// voxels, which is the same in every plane, so a plane is the plane before it, shifted cyclically: rows of eight
/// voxels at once, eight directions at a time.
///
/// Missing blocks: only those whose voxels others look at, by rays that are found once (void_pieces.h).
///
/// Threads: rows of a plane in parallel; values do not depend on their number.
class PeriodicSweep {
public:
    /// Whether the sweep takes media with this period: exactly two axes repeat.
    static bool takes(const Vec3i& period);

    PeriodicSweep(const VoxelIndex&, const std::vector<SweepFace>&);
    ~PeriodicSweep();

    void run(const SweepSet&, const SweepFields&, SweepResult&, PlaneLight*, SweepGround*);
    size_t bytes() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace vdbcloud
