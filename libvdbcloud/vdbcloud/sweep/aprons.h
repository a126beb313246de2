#pragma once
// Radiance that enters a block: from neighbouring blocks, through the void, or from the sky. Private to sweep/.
#include "vdbcloud/sweep/void_beams.h"
#include "vdbcloud/sweep/void_rays.h"

namespace vdbcloud {

class PatchLight;

/// One direction of a set and what its sweep needs of geometry.
struct SweepPath {
    SweepPath(const Vec3d& step, size_t number);
    block_sweep::Traversal traversal;
    size_t number;                ///< in the set
    std::vector<VoidBeam> beams;  ///< of each region of the apron
    size_t bytes() const;
};

/// Radiance and sources that pass from block to block, for the directions of the current batch and all channels. Rays
/// through the void are followed once for all channels. What a block passes to those beside it is kept until these are
/// done (Order::place), and what rays through the void may meet until the batch ends.
///
/// Threads: load() and leave() of different blocks, after leave() of the blocks upstream.
class Aprons {
public:
    /// Keeps references.
    Aprons(const Blocks&, const VoidRays&);

    /// Clears cached ray ends. Call when the direction set changes. A batch has `width` directions at most.
    void clear_cache(size_t directions, int width);
    /// Call before the first octant of a run. `places`: the most of all orders.
    void set_channels(int channels, size_t places);
    /// Call before the batches of an octant, with the signs of its steps by axis and the places of the blocks.
    /// `below`: by channel, the patch of ground that rays from the sky of this octant come from, after reflect();
    /// empty: none.
    void start(const std::array<int, 3>& sign, const std::vector<int32_t>& place,
               const std::vector<const PatchLight*>& below = {});
    /// Frees what the next run overwrites.
    void release();

    using Upstream = std::array<int32_t, 8>;  ///< the blocks upstream across axes given as bits; -1: none
    Upstream upstream(const std::array<int, 3>& sign, size_t block) const;

    /// The apron of sigma, for all traversals across the planes of one axis. 0 in the void.
    void load_sigma(const block_sweep::Traversal&, const float* sigma, const Upstream&, block_sweep::Scratch&) const;
    /// Aprons of radiance and source of direction d of the batch, for each channel: `inflow` and `s` by channel.
    void load(const SweepPath&, int d, size_t block, const Upstream&, const float* inflow, block_sweep::Scratch* s);
    /// What goes on from a block to those that follow, by channel: to be filled between load() and leave().
    block_sweep::DownstreamFaces* faces(size_t block, int d) { return &downstream_[at(size_t((*place_)[block]), d)]; }
    /// Takes what goes on from a block into the void, for each channel.
    void leave(const SweepPath&, int d, size_t block, const block_sweep::Scratch* s);

    /// Radiance of `channels` from `first` on, along direction d of the batch, at 8 x 8 points `pitch` voxels apart:
    /// from `corner` (block coordinates) along the axes `along`, the second fastest. The points lie downstream of all
    /// blocks that a ray to them meets; with pitch 1 in one missing block, else each in a missing block or its radiance
    /// has no meaning. Returns which rays come from the sky, as bits; their radiance is not set.
    uint64_t fill_tile(const SweepPath&, int d, size_t first, size_t channels, const Vec3d& corner,
                       const std::array<int, 2>& along, float* const* radiance, int pitch = 1) const;
    /// The same with pitch 1 where a ray to a point meets none but `count` of `blocks`.
    uint64_t fill_tile(const SweepPath&, int d, size_t first, size_t channels, const Vec3d& corner,
                       const std::array<int, 2>& along, float* const* radiance, const int32_t* blocks,
                       size_t count) const;

    size_t channels() const { return channels_; }
    size_t bytes() const;

private:
    struct Patch;
    /// Where the first channel of a place or of a kept face is.
    size_t at(size_t number, int d) const { return (number * width_ + size_t(d)) * channels_; }
    const float* face(size_t block, int axis, int d, size_t channel) const;
    void put_sky(const Patch&, int i, int j) const;
    void put_light(const Patch&, const VoidRays::Hit&, int i, int j) const;
    bool fill_patch(Patch&, const int* lo, const int* hi) const;
    uint64_t from_near_blocks(const SweepPath&, int d, int region, size_t block, float* const* radiance) const;
    void through_void(const SweepPath&, int d, int region, size_t block, const float* inflow, float* const* radiance);

    const Blocks& blocks_;
    const VoidRays& rays_;
    std::vector<const PatchLight*> below_;  // by channel; empty: none
    size_t width_ = 0, channels_ = 1;
    const std::vector<int32_t>* place_ = nullptr;           // by block
    std::vector<block_sweep::DownstreamFaces> downstream_;  // by place, `width_` each, by channel
    // By axis: the number of a block's downstream face that rays through the void may meet, or -1.
    std::vector<std::array<int32_t, 3>> outer_of_;
    std::vector<float> outer_;        // radiance on such faces, 64 each, `width_` each, by channel
    std::vector<uint16_t> ray_ends_;  // by direction and block: see through_void()
};

}  // namespace vdbcloud
