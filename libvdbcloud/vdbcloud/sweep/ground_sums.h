#pragma once
// The ground of a sweep while its light is gathered and sent up. Private to sweep/.
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

/// Threads: gather() of different cells; radiance() after reflect().
class GroundSums {
public:
    GroundSums(const Blocks&, SweepGround&);

    int face() const { return to_.face; }
    size_t cells() const { return sum_.size(); }
    Vec3i voxel(size_t cell) const { return box_.voxel(to_.face, cell); }
    /// Whether light along this direction ends on the ground; all other light begins there.
    bool leaves(const Vec3d& direction) const { return direction[to_.face / 2] * (to_.face % 2 ? 1 : -1) > 0; }
    bool black() const { return to_.albedo == 0; }

    /// Adds weight x |s.n| x L of a cell, and of a radiance of 1.
    void gather(size_t cell, double power) { sum_[cell] += power; }
    void gather_unit(double power) { unit_ += power; }
    /// Sets irradiance and radiance from what has been gathered.
    void reflect();

    /// Of the place where a ray through `point` (voxel coordinates) along `step` left the ground.
    double radiance(const Vec3d& point, const Vec3d& step) const;

private:
    ActiveBox box_;
    SweepGround& to_;
    int u_, v_, plane_;  // axes along the ground; its place across them
    double unit_ = 0;
    std::vector<double> sum_, radiance_;
};

}  // namespace vdbcloud
