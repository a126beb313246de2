#include "vdbcloud/sweep/void_rays.h"

#include "vdbcloud/sweep/block_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr size_t most_dense = size_t(1) << 18;  // tiles in the dense table

Vec3i shifted(const Vec3i& v, int bits) { return Emptiness::shifted(v, bits); }

int in_tile(const Vec3i& at) { return (at.x() & 15) * 256 + (at.y() & 15) * 16 + (at.z() & 15); }

}  // namespace

VoidRays::VoidRays(const Blocks& blocks)
    : blocks_(blocks), periodic_(blocks.period()[0] || blocks.period()[1] || blocks.period()[2]),
      emptiness_(periodic_ ? Emptiness() : Emptiness(blocks))
{
    first_ = Vec3i(std::numeric_limits<int>::max());
    last_ = Vec3i(std::numeric_limits<int>::min());
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Vec3i& at = blocks.at(b);
        for (int a = 0; a < 3; ++a) {
            first_[a] = std::min(first_[a], at[a]);
            last_[a] = std::max(last_[a], at[a]);
        }
        tiles_[shifted(at, 4)].places.set(in_tile(at));
    }
    if (!blocks.count()) return;
    uint32_t placed = 0;
    for (auto& [at, of] : tiles_) {
        of.first = placed;
        placed += uint32_t(of.places.count());
    }
    order_.resize(blocks.count());
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Tile& of = tiles_.at(shifted(blocks.at(b), 4));
        order_[of.first + size_t(of.places.rank(in_tile(blocks.at(b))))] = int32_t(b);
    }
    dense_first_ = shifted(first_, 4);
    dense_size_ = shifted(last_, 4) - dense_first_ + Vec3i(1);
    const double size = double(dense_size_[0]) * dense_size_[1] * dense_size_[2];
    if (size > double(most_dense)) return;
    dense_.assign(size_t(size), nullptr);
    for (size_t n = 0; n < dense_.size(); ++n) {
        const int z = int(n % dense_size_[2]), y = int(n / dense_size_[2] % dense_size_[1]);
        const int x = int(n / dense_size_[2] / dense_size_[1]);
        const auto found = tiles_.find(dense_first_ + Vec3i(x, y, z));
        if (found != tiles_.end()) dense_[n] = &found->second;
    }
}

const VoidRays::Tile* VoidRays::tile(const Vec3i& at) const
{
    if (!dense_.empty()) {
        const Vec3i d = at - dense_first_;
        for (int a = 0; a < 3; ++a)
            if (d[a] < 0 || d[a] >= dense_size_[a]) return nullptr;
        return dense_[(size_t(d.x()) * dense_size_[1] + d.y()) * dense_size_[2] + d.z()];
    }
    const auto found = tiles_.find(at);
    return found == tiles_.end() ? nullptr : &found->second;
}

int32_t VoidRays::block(const Tile& of, int place) const
{
    return of.places.has(place) ? order_[of.first + size_t(of.places.rank(place))] : -1;
}

int32_t VoidRays::find(const Vec3i& place) const
{
    Vec3i at = place;
    for (int a = 0; a < 3 && periodic_; ++a) {
        const int period = blocks_.period()[a];
        if (period == 0 || (at[a] >= 0 && at[a] < period)) continue;
        at[a] %= period;
        at[a] += at[a] < 0 ? period : 0;
    }
    const Tile* in = tile(shifted(at, 4));
    return in ? block(*in, in_tile(at)) : -1;
}

size_t VoidRays::bytes() const
{
    return tiles_.size() * (sizeof(Vec3i) + sizeof(Tile) + 2 * sizeof(void*)) + order_.size() * sizeof(int32_t) +
           emptiness_.bytes() + dense_.size() * sizeof(void*);
}

VoidRays::Hit VoidRays::trace(const Vec3d& point, const Vec3d& step) const
{
    Walk walk(point, step);
    Hit hit;
    Vec3i in(0, 0, 0);
    const Tile* here = nullptr;
    for (bool first = true;; first = false) {
        int bits = 0, found = -1;
        if (periodic_) {
            found = find(walk.block);
        } else {
            const Vec3i at = shifted(walk.block, 4);
            if (first || at != in) {
                in = at;
                here = tile(at);
            }
            if (here)
                if (const int place = in_tile(walk.block); here->places.has(place))
                    found = block(*here, place);
                else
                    bits = here->empty_about(place) ? 2 : 0;
            else
                bits = emptiness_.bits(walk.block, 1);
        }
        if (found >= 0 && !first) {
            hit.block = found;
            for (int a = 0; a < 3; ++a) hit.at[a] = walk.in_block(hit.axes, a);
            return hit;
        }
        if (bits) walk.face_walls(bits);
        hit.axes = walk.cross(bits);
        for (int a = 0; a < 3; ++a)
            if (blocks_.period()[a] == 0 &&
                ((step[a] >= 0 && walk.block[a] < first_[a]) || (step[a] <= 0 && walk.block[a] > last_[a]))) {
                hit.axes = 0;
                return hit;
            }
    }
}

VoidRays::Hit VoidRays::trace(const Vec3d& point, const Vec3d& step, const int32_t* blocks, size_t count) const
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const Vec3d from = point + Vec3d(0.5);
    Hit hit;
    double nearest = infinity;
    for (size_t n = 0; n < count; ++n) {
        const Vec3i& at = blocks_.at(size_t(blocks[n]));
        // Ray parameters at the walls that the ray crosses into the block and out of it, by axis.
        double in[3], out[3], last = 0;
        int last_axis = -1;
        for (int a = 0; a < 3; ++a) {
            const double low = 8.0 * at[a], to_low = from[a] - low, to_high = to_low - 8;
            if (step[a] == 0) {
                in[a] = to_low >= 0 && to_high < 0 ? -infinity : infinity;
                out[a] = infinity;
            } else {
                in[a] = (step[a] > 0 ? to_high : to_low) / step[a];
                out[a] = (step[a] > 0 ? to_low : to_high) / step[a];
            }
            if (in[a] > last) last = in[a], last_axis = a;
        }
        if (last_axis < 0 || last == infinity) continue;
        // Walls this close are met at once (Walk::cross): an edge that is only touched stops no ray.
        double t = last;
        for (const double wall : in)
            if ((last - wall) * std::abs(step[last_axis]) < same_wall) t = std::min(t, wall);
        int axes = 0;
        bool meets = t < nearest;
        for (int a = 0; a < 3; ++a) {
            axes |= in[a] >= t ? 1 << a : 0;
            meets = meets && (out[a] == infinity || (out[a] - t) * std::abs(step[a]) >= same_wall);
        }
        if (!meets) continue;
        nearest = t;
        hit.block = blocks[n];
        hit.axes = axes;
        for (int a = 0; a < 3; ++a)
            hit.at[a] = axes >> a & 1 ? (step[a] > 0 ? 7.5 : -0.5) : from[a] - t * step[a] - 0.5 - 8.0 * at[a];
    }
    return hit;
}

}  // namespace vdbcloud
