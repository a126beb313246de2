#pragma once
// Where a cloud may be: regions of space with a depth.
#include "vdbcloud/core/fwd.h"

#include <limits>
#include <memory>
#include <vector>

namespace vdbcloud {

/// An axis-aligned box [world].
struct Box {
    Vec3d low{-1, -1, -1}, high{1, 1, 1};

    Vec3d sides() const { return high - low; }
    Vec3d centre() const { return 0.5 * (low + high); }
    Box inset(double by) const { return {low + Vec3d(by), high - Vec3d(by)}; }
};

/// A region by its depth at a point [world]: positive inside, 0 on its surface, negative outside; near the
/// surface about the distance to it. Immutable, so shared by threads.
///
/// A region made of many parts is asked in two steps: first which parts matter within a ball, then the depth
/// at points of the ball by those parts alone. A region of one part leaves the lists empty.
class Envelope {
public:
    struct Range {
        float low, high;  ///< bounds of the depth [world]
    };
    struct Parts {
        std::vector<float> data;  ///< as the envelope lays it out
        int count = 0;
    };

    virtual ~Envelope() = default;
    virtual const Parts& all() const;

    struct Ball {
        Vec3f centre;
        float radius;  ///< [world]
    };

    /// Bounds of the depth over the ball; `near`, another list than `from`, becomes those of `from` that
    /// matter in it. A part whose depth is nowhere above `least` does not matter: where no other is deeper,
    /// the depth is at most `least` and no closer bound is given.
    virtual Range select(const Parts& from, const Ball&, float least, Parts& near) const = 0;

    /// out[p] = depth at (x[p], y[p], z[p]), for `count` points inside the ball that `near` was selected for.
    /// The arrays do not overlap.
    virtual void depth(const Parts& near, int count, const float* x, const float* y, const float* z,
                       float* out) const = 0;

    /// Height along the up axis below which there is nothing [world]: a flat base.
    virtual float base() const { return -std::numeric_limits<float>::infinity(); }
};

using EnvelopePtr = std::unique_ptr<const Envelope>;

/// The largest sphere in the box. Depth: the distance to its surface.
EnvelopePtr sphere_envelope(const Box&);

/// The ellipsoid that touches the box, of semi-axes a: depth = a_min (1 - |p / a|), which is nowhere more
/// than the distance.
EnvelopePtr ellipsoid_envelope(const Box&);

/// The box itself: the distance to the nearest face plane.
EnvelopePtr box_envelope(const Box&);

/// The layer between the box's faces across axis `up` (0, 1, 2), without other sides.
EnvelopePtr slab_envelope(const Box&, int up);

}  // namespace vdbcloud
