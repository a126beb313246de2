#include "vdbcloud/fractal/mask_envelope.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/distance_field.h"

#include <openvdb/tools/Interpolation.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

class Mask : public Envelope {
public:
    Mask(const Box& domain, const Vec3i& size, std::vector<float> depth)
        : size_(size), low_(domain.low), depth_(std::move(depth))
    {
        const Vec3d sides = domain.sides();
        for (int d = 0; d < 3; ++d) inverse_[d] = float(size[d] / sides[d]);
        cell_ = Vec3f(1 / inverse_[0], 1 / inverse_[1], 1 / inverse_[2]).length();
    }

    /// An interpolated value is a mean of values at most a cell away, each of which is a distance.
    Range select(const Parts&, const Ball& ball, float, Parts& near) const override
    {
        near.count = 0;
        const float x = ball.centre[0], y = ball.centre[1], z = ball.centre[2], reach = ball.radius + 2 * cell_;
        float d = 0;
        depth(near, 1, &x, &y, &z, &d);
        return {d - reach, d + reach};
    }

    void depth(const Parts&, int count, const float* x, const float* y, const float* z, float* out) const override
    {
        const size_t sx = size_t(size_[1]) * size_t(size_[2]), sy = size_t(size_[2]);
        for (int p = 0; p < count; ++p) {
            size_t at[3], next[3];
            float f[3];
            const float position[3] = {x[p], y[p], z[p]};
            for (int d = 0; d < 3; ++d) {
                const float q = (position[d] - low_[d]) * inverse_[d] - 0.5f, top = float(size_[d] - 1);
                const float held = std::min(std::max(q, 0.0f), top);
                at[d] = size_t(held);
                next[d] = std::min(at[d] + 1, size_t(size_[d] - 1));
                f[d] = held - float(at[d]);
            }
            const auto row = [&](size_t i, size_t j) {
                const float* r = depth_.data() + i * sx + j * sy;
                return r[at[2]] + f[2] * (r[next[2]] - r[at[2]]);
            };
            const float a = row(at[0], at[1]), b = row(at[0], next[1]), c = row(next[0], at[1]),
                        e = row(next[0], next[1]);
            const float low = a + f[1] * (b - a), high = c + f[1] * (e - c);
            out[p] = low + f[0] * (high - low);
        }
    }

private:
    Vec3i size_;
    Vec3f low_, inverse_;
    float cell_ = 0;
    std::vector<float> depth_;
};

std::vector<uint8_t> inside(const FloatGrid& mask, const Box& domain, const Vec3i& size, double level)
{
    const bool surface = mask.getGridClass() == openvdb::GRID_LEVEL_SET;
    float most = 0;
    if (!surface)
        for (auto it = mask.cbeginValueOn(); it; ++it) most = std::max(most, *it);
    const float threshold = float(level) * most;
    const Vec3d sides = domain.sides(), step(sides[0] / size[0], sides[1] / size[1], sides[2] / size[2]);
    const size_t voxels = size_t(size[0]) * size_t(size[1]) * size_t(size[2]);
    std::vector<uint8_t> set(voxels);
    tbb::parallel_for(tbb::blocked_range<int>(0, size[0]), [&](const auto& range) {
        const auto accessor = mask.getConstAccessor();
        for (int i = range.begin(); i != range.end(); ++i)
            for (int j = 0; j < size[1]; ++j)
                for (int k = 0; k < size[2]; ++k) {
                    const Vec3d world = domain.low + step * Vec3d(i + 0.5, j + 0.5, k + 0.5);
                    const float v = openvdb::tools::BoxSampler::sample(accessor, mask.transform().worldToIndex(world));
                    set[(size_t(i) * size_t(size[1]) + size_t(j)) * size_t(size[2]) + size_t(k)] =
                        surface ? v < 0 : v > threshold;
                }
    });
    return set;
}

}  // namespace

EnvelopePtr mask_envelope(const FloatGrid& mask, const Box& domain, const Vec3i& size, double level)
{
    const auto set = inside(mask, domain, size, level);
    if (std::find(set.begin(), set.end(), 1) == set.end())
        throw InputError("mask '" + mask.getName() + "': nothing of it is inside the bounds");
    const Vec3d sides = domain.sides();
    return std::make_unique<Mask>(
        domain, size, signed_distance(size, {sides[0] / size[0], sides[1] / size[1], sides[2] / size[2]}, set));
}

Box mask_bounds(const FloatGrid& mask)
{
    openvdb::CoordBBox box;
    if (!mask.tree().evalActiveVoxelBoundingBox(box)) throw InputError("mask '" + mask.getName() + "' is empty");
    const Vec3d low = box.min().asVec3d() - Vec3d(0.5), high = box.max().asVec3d() + Vec3d(0.5);
    Box out{Vec3d(1e300), Vec3d(-1e300)};
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d index(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2]);
        const Vec3d world = mask.transform().indexToWorld(index);
        for (int d = 0; d < 3; ++d) {
            out.low[d] = std::min(out.low[d], world[d]);
            out.high[d] = std::max(out.high[d], world[d]);
        }
    }
    return out;
}

}  // namespace vdbcloud
