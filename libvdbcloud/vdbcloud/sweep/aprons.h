#pragma once
// The light that reaches a block: from the blocks beside it, through the void, or from the sky. Private to sweep/.
#include "vdbcloud/sweep/void_beams.h"
#include "vdbcloud/sweep/void_rays.h"

namespace vdbcloud {

/// One direction of a set and what its sweep needs of geometry.
struct SweepPath {
    SweepPath(const Vec3d& step, size_t number);
    block_sweep::Frame frame;
    size_t number;                ///< in the set
    std::vector<VoidBeam> beams;  ///< of each region of the apron
    size_t bytes() const;
};

/// What blocks show downstream and what they see upstream, for the directions of a batch, which are under way.
///
/// Threads: load() and show() of different blocks, once the blocks upstream have shown.
class Aprons {
public:
    explicit Aprons(const Blocks&);

    /// The directions are others than before, `width` of them at most in a batch: forgets which rays end in the sky.
    void forget(size_t directions, int width);
    /// Before the batches of an octant: signs of its steps by axis.
    void start(const std::array<int, 3>& sign);

    using Upstream = std::array<int32_t, 8>;  ///< the blocks upstream across axes given as bits; -1: none
    Upstream upstream(const std::array<int, 3>& sign, size_t block) const;

    /// sigma of a block with its apron, for all frames of one layout. 0 in the void.
    void load_sigma(const block_sweep::Frame&, const float* sigma, size_t block, const Upstream&, float* padded) const;
    /// Aprons of radiance and source of direction d of the batch.
    void load(const SweepPath&, int d, size_t block, const Upstream&, float inflow, block_sweep::Scratch&);
    /// Keeps what later blocks need of this one.
    void show(const SweepPath&, int d, size_t block, const block_sweep::Scratch&);

    size_t bytes() const;

private:
    struct Shown {
        block_sweep::Faces radiance, source;
    };
    struct Patch;
    const float* face(size_t block, int face, int axis, int d) const;
    float light_of(const Patch&, const VoidRays::Hit&) const;
    bool fill_patch(Patch&, const int* lo, const int* hi, float* radiance) const;
    void through_void(const SweepPath&, int d, int region, size_t block, float inflow, float* radiance);

    const Blocks& blocks_;
    VoidRays rays_;
    size_t width_ = 0;
    std::vector<Shown> shown_;  // block by block, `width_` each
    std::vector<std::array<int32_t, 3>>
        outer_of_;                 // by axis: the number of a block's downstream face that looks into the void, or -1
    std::vector<float> outer_;     // radiance that leaves such faces, 64 each, `width_` each
    std::vector<uint16_t> known_;  // by direction and block: see through_void()
};

}  // namespace vdbcloud
