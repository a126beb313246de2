#pragma once
// A few directions through one block of 8^3 voxels: the inner loops of transport_sweep. Private to sweep/.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/voxels/blocks.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdbcloud::block_sweep {

inline constexpr int batch = 8;          ///< directions that are taken through a block together, at most
inline constexpr int group = 4;          ///< they are summed in groups
inline constexpr int most_channels = 3;  ///< whose light goes through a block together

/// A block with the aprons of its neighbours: (x, y, z), each -1..8, at (x+1) stride[0] + (y+1) stride[1] + (z+1)
/// stride[2] + first. Rows of eight are contiguous along one axis: z, or y for directions that cross planes of z.
struct Layout {
    std::array<int, 3> stride;      ///< in a padded block
    std::array<int, 3> row_stride;  ///< in 512 values without apron
    static constexpr int size = 1600, first = 3;
};
inline constexpr Layout natural{{160, 16, 1}, {64, 8, 1}};
inline constexpr Layout turned{{16, 1, 160}, {8, 1, 64}};

/// Geometry of one direction within blocks. Planes are crossed along axis w; u and v are the others, v the contiguous
/// one. What has an entry for each of w, u, v is in "traversal order".
struct Traversal {
    explicit Traversal(const Vec3d& step);  ///< step: voxels per world unit

    int at(int p, int r, int c) const { return (p + 1) * stride[0] + (r + 1) * stride[1] + c + 1 + Layout::first; }

    const Layout* layout;
    Vec3d step;
    std::array<int, 3> axis;          ///< w, u, v
    std::array<int, 3> stride;        ///< of a padded block, traversal order
    std::array<int, 3> row_stride;    ///< of 512 values in the layout's order, traversal order
    std::array<int, 3> slot_stride;   ///< of 512 values in slot order, traversal order
    std::array<int, 3> sign;          ///< of step, traversal order
    std::array<int, 3> before, last;  ///< coordinates upstream of the block and in its last plane, traversal order
    std::array<int, 7> region;        ///< axes of each region of the apron (below) as bits, x the lowest
    /// Half the length from one centre to the plane of the next along each axis, traversal order.
    std::array<float, 3> half_exit;
    float u_up, v_up;  ///< bilinear weights of the upstream row and column
    float half_step;   ///< half the length from plane to plane [world unit]
};

/// Regions of a block's upstream apron, by the axes along which they lie outside it as bits in traversal order: faces,
/// edges, the corner. Values of a region are in traversal order of the coordinates that run, the last fastest: 64, 8
/// or 1.
inline constexpr int regions = 7;
inline constexpr int region_axes[regions] = {1, 2, 4, 3, 5, 6, 7};
constexpr int region_size(int region) { return region < 3 ? 64 : region < 6 ? 8 : 1; }

/// Values on the last centres before each downstream face of a block, faces and coordinates in traversal order.
using FaceValues = std::array<std::array<float, 64>, 3>;

/// What goes on from a block: radiance, and sigma_t q.
struct DownstreamFaces {
    FaceValues radiance, source;
};

/// Where the values of each region are.
struct Apron {
    std::array<const float*, regions> region;
    int pitch = 1;  ///< from value to value of region 5, which runs along w; other regions are contiguous
};

/// Rows of eight slots with an active voxel.
struct Rows {
    explicit Rows(const BlockMask&);
    int count = 0, lines = 0;
    uint8_t row[64];
    uint8_t line[32];  ///< pairs of rows: 64 bytes, a line of the cache
};

/// One channel's light in a block, and the medium: `sigma`, `sigma_before` and `lit`, which channels share.
struct alignas(64) Scratch {
    const float* sigma = nullptr;          ///< 512 values in the current layout's order
    const float* radiance = nullptr;       ///< the same of the last direction that was swept
    const float* wall = nullptr;           ///< the same: radiance of opaque voxels, NaN of others; null: no such voxels
    float q[batch][512];                   ///< direction by direction, in its layout's order
    float out[batch][512];                 ///< radiance, in slot order
    float source[512];                     ///< sigma q of one direction, in its layout's order
    float turned_sigma[512], turned[512];  ///< room for `sigma` and `radiance`
    float walls[512];                      ///< room for `wall`
    Apron sigma_before, radiance_before, source_before;
    float sigma_apron[regions][64];  ///< room for values of sigma_before
    float from_void[regions][64];    ///< and of radiance_before, where blocks are missing
    float padded[Layout::size];      ///< radiance and its apron: pad()
    std::array<uint8_t, 8> lit;      ///< rows that emit or absorb, or what lies upstream of them, plane by plane
};

inline constexpr float zeros[64] = {};

/// sigma in the layout's order. `values` is in slot order and stays in use.
void take_sigma(const Layout&, const float* values, Scratch& s);
/// The values of a region of the apron in `values`, those of the block that it lies in; in slot order.
void take_region(const Traversal&, int region, const float* values, float* to);
/// The region of the apron in the faces of the block that it lies in.
const float* region_of(const Traversal&, int region, const FaceValues& neighbour);
constexpr int pitch_of_faces = 8;  ///< Apron::pitch of region_of()

/// Prefetches the active rows of the arrays from .. to - 1.
void fetch(const Rows&, int from, int to, float* const* arrays);
/// s.q[d] = sum over terms k of basis[k * batch + d] source[k], each a pointer to the block's 512 values; in the
/// natural order. For the directions 0 .. n - 1 and others up to a multiple of `group`.
void expand(const Rows&, int n, int terms, const float* const* source, const float* basis, Scratch& s);
/// Brings a direction's q to its layout's order.
void prepare(const Traversal&, int d, Scratch&);
/// Sets s.wall: none but in the voxels (slots in the block) that set_wall() names then.
void clear_walls(Scratch&);
void set_wall(const Layout&, size_t slot, float radiance, Scratch&);
/// Finds s.lit from the active voxels and the apron of sigma.
void find_lit(const Traversal&, const BlockMask&, Scratch&);

/// Sweeps the planes for `channels` of `s`, 1 to most_channels, in the medium of the first: s.radiance from the aprons
/// of radiance, sigma and source, and what goes on from the block. Then `out` of d holds the radiance in slot order.
/// `emission`: SweepFields::emission. All channels have walls, or none has. A channel's values do not depend on the
/// others.
void sweep_planes(const Traversal&, int d, bool emission, int channels, Scratch* s, DownstreamFaces* to);
/// Takes the medium of another channel, which stays in use.
void share_medium(const Scratch& of, Scratch& to);

/// s.padded from s.radiance and its apron.
void pad(const Traversal&, Scratch&);
/// Radiance on a downstream face (traversal order) after half a voxel more, from that on its last centres.
void leave_face(const Traversal&, int face, int d, const Scratch&, const std::array<float, 64>& radiance, float* to);

/// moments[k] += sum over d of weight[k * batch + d] out[d], for `terms` arrays of 512 values. d as in expand().
/// `first`: overwrites the moments.
void accumulate(const Rows&, int n, int terms, bool first, float* const* moments, const float* weight,
                const Scratch& s);

/// n values, a multiple of eight: radiance e^-tau + q (1 - e^-tau), tau = sigma length.
void leave(int n, const float* radiance, const float* sigma, const float* q, float length, float* result);
/// to[a][i] += factor[a] values[i], three arrays of n values.
void add(size_t n, const float* values, const std::array<float, 3>& factor, const std::array<float*, 3>& to);

}  // namespace vdbcloud::block_sweep
