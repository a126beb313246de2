#pragma once
// What the parts of the sweep of periodic media share: planes, faces and voids. Private to sweep/.
#include "vdbcloud/sweep/ground_sums.h"
#include "vdbcloud/sweep/periodic_sweep.h"
#include "vdbcloud/sweep/plane_kernel.h"
#include "vdbcloud/sweep/void_pieces.h"

#include <functional>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <optional>

namespace vdbcloud {

namespace periodic {

inline int wrapped(int k, int size)
{
    k %= size;
    return k < 0 ? k + size : k;
}

/// Calls f(0) ... f(count - 1), in parallel where there is work for it.
template<typename F>
void each(int count, bool large, const F& f)
{
    if (large)
        tbb::parallel_for(0, count, f);
    else
        for (int n = 0; n < count; ++n) f(n);
}

}  // namespace periodic

struct PeriodicSweep::Impl {
    /// How a direction meets the faces of one orientation: the weights and places, from a voxel, of the four voxels
    /// whose light counts there.
    struct View {
        bool leaves = false, along = false;
        double half_exit = 0;  // half the length through a voxel across the face
        std::array<double, 4> weight{};
        std::array<int, 4> row{}, column{};
        std::array<bool, 4> before{};  // in the plane before
    };
    /// A direction of a batch.
    struct Way {
        Vec3d step;  // voxels per world unit
        size_t number;
        float sky;
        std::array<View, 6> views;  // by Blocks::Face
    };
    std::array<View, 6> views_of(const Vec3d& step) const;

    /// The planes of a sweep lie across `w`, an axis that ends.
    Impl(const VoxelIndex&, const std::vector<SweepFace>&, int w);

    // Layers of blocks, planes of voxels. A tile is a block's part of a plane.
    int32_t block_at(int layer, int bu, int bv) const
    {
        return layer < 0 || layer >= layers ? -1 : tiles[size_t((layer * tu + bu) * tv + bv)];
    }
    int layer_of(int p) const { return (p >> 3) - first_layer; }
    int row_of(const Vec3i& voxel) const { return voxel[u] - 8 * first_u; }
    int column_of(const Vec3i& voxel) const { return voxel[v] - 8 * first_v; }
    size_t cell(int row, int column) const { return size_t(row) * plane_kernel::pitch_of(nv) + size_t(column); }

    void start(const SweepSet&, const SweepFields&, SweepResult&, PlaneLight*, SweepGround*);
    void run(const std::vector<Way>&);
    void sweep(int sign, const std::vector<Way>&);
    void enter(int p, const std::vector<Way>&);
    void cross_plane(int p, const std::vector<Way>&, plane_kernel::Job&);
    void find_pieces(int sign, int d, const Way&);
    void fill_voids(int p, int d, const Way&);
    /// The voxels of a tile that others look at, as bits 8 u + v: in every plane of the layer, and in its last plane.
    struct Part {
        uint64_t all = 0, last = 0;
    };
    void find_needed(int here, int next, const plane_kernel::Offset&, std::vector<Part>&) const;
    /// Repeats the first columns of rows at their ends.
    void close_rows(float* plane, int first, int count) const
    {
        for (int row = first; row < first + count; ++row) std::copy_n(plane + cell(row, 0), 8, plane + cell(row, nv));
    }
    void keep_exits(int p, int bu, int bv, int d, const Way&);
    void tally(int p, int sign, const std::vector<Way>&);
    void leave(int p, int sign, const std::vector<Way>&, bool of_blocks);
    void leave_aside(int p, const std::vector<Way>&, bool of_blocks);
    /// Sums of a row of cells, by direction of a batch: from the medium, and from the sky.
    using RowSums = std::array<std::array<double, 2>, plane_kernel::batch>;
    /// Adds the light of one cell in direction d; `light`: none from the medium.
    void add_cell(int face, size_t cell, const Way&, double out, const std::optional<double>& light,
                  std::array<double, 2>& row);
    void add_rows(const std::vector<RowSums>&, const std::vector<Way>&, const std::function<int(const Way&)>& face_of);
    void forget(const std::vector<Way>&);

    double on_face(int d, const Way&, const Vec3i& voxel, int face) const;
    std::optional<double> through_void(int d, const Way&, const Vec3d& point) const;
    double outside(const Way& way, const Vec3d& point) const
    {
        return upward && ground ? ground->radiance(point, way.step) : double(way.sky);
    }
    double light_of(int d, const Way&, const VoidRays::Hit&) const;

    void fill_from_outside(const VoidPiece&, int p, int tile, const Way&, float* to) const;
    void fill_from_block(const VoidPiece&, int in_block, int d, const Way&, float* to) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    const VoidRays rays;
    const ActiveBox box;
    int w, u, v;     // across the planes; along them
    int aside = -1;  // of u and v the axis that ends, with a missing tile before the first block and after the last
    int nu, nv, tu, tv;
    int first_u = 0, first_v = 0;  // blocks
    int first_layer = 0, layers = 0;
    std::vector<int32_t> tiles;  // blocks by layer, u, v; -1: missing
    std::vector<char> whole;     // layers without missing tiles
    bool has_voids = false, large = false;
    struct Face {
        uint32_t number;
        Vec3i voxel;
        uint8_t face;
    };
    std::vector<std::vector<Face>> faces;  // by plane
    size_t face_count;

    // Of the run:
    const SweepSet* set = nullptr;
    const SweepFields* fields = nullptr;
    SweepResult* result = nullptr;
    std::optional<GroundSums> ground;
    bool upward = false;  // directions begin on the ground
    std::vector<std::array<double, 3>> sums;
    std::array<std::vector<double>, 6> from_medium, from_sky;    // by Blocks::Face
    std::array<std::vector<double>, 6> medium_along, sky_along;  // the same, by direction of the set
    bool with_planes = false;
    // Of the batch: the plane before and the one now, by `now`.
    int now = 0;
    std::vector<float> radiance[2][plane_kernel::batch], source[2][plane_kernel::batch], sigma[2];
    std::vector<plane_kernel::Offset> offsets;
    struct Pieces {
        std::vector<VoidPiece> list;
        std::vector<uint32_t> begin;  // of each tile of each layer, and the end

        size_t bytes() const { return list.size() * sizeof(VoidPiece) + begin.size() * sizeof(uint32_t); }
    };
    std::vector<Pieces> pieces;  // by direction
    std::vector<Vec3d> known;    // directions that the pieces are of
    std::vector<float> exits;    // by block, direction, axis: radiance on the 8 x 8 centres before a downstream face
};

}  // namespace vdbcloud
