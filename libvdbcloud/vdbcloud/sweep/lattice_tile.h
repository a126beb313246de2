#pragma once
// A square of the light lattice's rays and their depths, advanced along w. Private to sweep/.
#include "vdbcloud/sweep/lattice_frame.h"

namespace vdbcloud {

/// Rays at integer positions (a0, b0) .. + rays - 1 and at r x r phases of each, advanced from stop to stop. A tile
/// owns the targets between its rays, `tile` positions along u and v.
///
/// Each step is summed in single precision and added to the depth in double: relative error below (number of taps + 1)
/// x 2^-24 of a step, so of the depth. Taps are 27 at most, so transmittance errs by less than 28 x 2^-24 / e.
class LatticeTile {
public:
    static constexpr int rays = 32;        ///< four vectors of eight
    static constexpr int tile = rays - 1;  ///< the last ray is there to interpolate towards

    /// `stops`: fractions of a plane at which rays stop, rising. Keeps references.
    LatticeTile(const BrickMap& density, const LatticeFrame& frame, const std::vector<double>& stops,
                int rays_per_voxel, int a0, int b0);

    /// To w = n + stops[stop] from the stop before.
    void advance(int n, size_t stop);

    /// The part of a voxel plane that reaches rays of one lattice phase [values].
    size_t values(int w);

    /// Values of voxels that were added to rays.
    size_t products() const { return products_; }

    /// Density depths, after advance() to (n, the offset's stop), at the targets of one block that lie on this stop and
    /// belong to this tile.
    void write(int n, const LatticeOffset& offset, const Vec3i& block, float* value) const;

private:
    static constexpr int margin = 4;  // voxels that a plane buffer holds beyond the tile on each side
    static constexpr int span = rays + 2 * margin + 4;

    /// The voxels of one plane w about a tile: value (v, u) at value[v * span + u], the first voxel being (v0, u0).
    struct Plane {
        int w = 0, u0 = 0, v0 = 0;
        bool valid = false;
        int u_low = span, u_high = -1, v_low = span, v_high = -1;  // of the values that are not 0
        std::array<float, span * span> value;

        bool any() const { return u_high >= u_low; }
        void clear();
        void copy_row(const float* from, int stride, int v, int first, int last);
    };

    /// The values of a plane of voxels, gathered when it is new. Four are kept: a step needs three.
    const Plane& plane(int w);
    double* phase(int p, int q) { return depth_.data() + size_t(q * r_ + p) * rays * rays; }
    void add_step(const LatticeTaps& taps, double* depth);

    const BrickMap& density_;
    const LatticeFrame& f_;
    const std::vector<double>& stops_;
    int r_, a0_, b0_;
    size_t products_ = 0;
    std::vector<double> depth_;  // [phase q, p][b][a], density x world unit
    std::array<Plane, 4> planes_;
};

}  // namespace vdbcloud
