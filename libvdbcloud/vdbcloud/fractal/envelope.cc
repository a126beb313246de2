#include "vdbcloud/fractal/envelope.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

/// A region whose depth changes by at most the distance between two points.
class Smooth : public Envelope {
public:
    Range select(const Parts&, const Ball& ball, float, Parts& near) const override
    {
        near.count = 0;
        const float x = ball.centre[0], y = ball.centre[1], z = ball.centre[2];
        float d = 0;
        depth(near, 1, &x, &y, &z, &d);
        return {d - ball.radius, d + ball.radius};
    }
};

class Ellipsoid : public Smooth {
public:
    Ellipsoid(const Vec3d& centre, const Vec3d& axes)
        : centre_(centre), inverse_(Vec3d(1 / axes[0], 1 / axes[1], 1 / axes[2])),
          least_(float(std::min({axes[0], axes[1], axes[2]})))
    {
    }
    void depth(const Parts&, int count, const float* x, const float* y, const float* z, float* out) const override
    {
        for (int p = 0; p < count; ++p) {
            const float a = (x[p] - centre_[0]) * inverse_[0], b = (y[p] - centre_[1]) * inverse_[1],
                        c = (z[p] - centre_[2]) * inverse_[2];
            out[p] = least_ * (1 - std::sqrt(a * a + b * b + c * c));
        }
    }

private:
    Vec3f centre_, inverse_;
    float least_;
};

/// The points between two faces along each axis that has any.
class Slabs : public Smooth {
public:
    Slabs(const Vec3d& low, const Vec3d& high) : low_(low), high_(high) {}
    void depth(const Parts&, int count, const float* x, const float* y, const float* z, float* out) const override
    {
        for (int p = 0; p < count; ++p) {
            const float a = std::min(x[p] - low_[0], high_[0] - x[p]), b = std::min(y[p] - low_[1], high_[1] - y[p]),
                        c = std::min(z[p] - low_[2], high_[2] - z[p]);
            out[p] = std::min(a, std::min(b, c));
        }
    }

private:
    Vec3f low_, high_;
};

Vec3d half_sides(const Box& box)
{
    const Vec3d half = 0.5 * box.sides();
    if (half[0] > 0 && half[1] > 0 && half[2] > 0) return half;
    std::ostringstream what;
    what << "box from " << box.low << " to " << box.high
         << ": expected the first corner below the second on every axis";
    throw InputError(what.str());
}

}  // namespace

const Envelope::Parts& Envelope::all() const
{
    static const Parts none;
    return none;
}

EnvelopePtr sphere_envelope(const Box& box)
{
    const Vec3d half = half_sides(box);
    return std::make_unique<Ellipsoid>(box.centre(), Vec3d(std::min({half[0], half[1], half[2]})));
}

EnvelopePtr ellipsoid_envelope(const Box& box) { return std::make_unique<Ellipsoid>(box.centre(), half_sides(box)); }

EnvelopePtr box_envelope(const Box& box)
{
    half_sides(box);
    return std::make_unique<Slabs>(box.low, box.high);
}

EnvelopePtr slab_envelope(const Box& box, int up)
{
    half_sides(box);
    Vec3d low(-1e30), high(1e30);
    low[up] = box.low[up];
    high[up] = box.high[up];
    return std::make_unique<Slabs>(low, high);
}

}  // namespace vdbcloud
