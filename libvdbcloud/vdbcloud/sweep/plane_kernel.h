#pragma once
// A row of a plane of voxels from the plane before it: the inner loop of periodic_sweep. Private to sweep/.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbcloud::plane_kernel {

inline constexpr int batch = 8;  ///< directions that are taken through a plane together, at most

/// Where the characteristics of a direction begin in the plane before: at one offset from each voxel.
struct Offset {
    /// step: voxels per world unit; w across the planes, u and v along them; n: voxels of a period.
    Offset(const Vec3d& step, int w, int u, int v, int nu, int nv);

    int u, v;                  ///< whole voxels, 0 .. n - 1
    float c00, c01, c10, c11;  ///< bilinear weights of the four voxels from there on: none, v, u, both
    float half_step;           ///< half the length from plane to plane [world unit]
};

/// Values of a row in a plane: its columns, and its first eight once more, so that no row wraps.
constexpr size_t pitch_of(int columns) { return size_t(columns) + 8; }

/// Values on a plane, row by row.
struct ConstPlane {
    const float *radiance, *source;
};
struct Plane {
    float *radiance, *source;
};

/// What the rows of one plane share. Arrays of fields are over slots.
struct Job {
    int directions = 0;
    const Offset* offsets = nullptr;
    const float* sigma = nullptr;
    std::vector<const float*> source;  ///< S / sigma_t, term by term
    std::vector<float*> moments;
    const float *basis = nullptr, *weight = nullptr;  ///< term by term, `batch` each
    std::array<ConstPlane, batch> before{};
    std::array<Plane, batch> here{};
    const float* sigma_before = nullptr;
    float* sigma_here = nullptr;
    int rows = 0, columns = 0;
    bool emission = false;   ///< SweepFields::emission
    bool contiguous = true;  ///< the voxels of a row are neighbours in memory; else eight slots apart
};

/// One row: radiance, source and sigma_t of `here`, and the row's part of the moments. `blocks`: of the row's tiles, -1
/// where a block is missing: source and sigma_t are 0 there, radiance is left. `in_block`: slot of the row's first
/// voxel in its block.
void sweep_row(const Job&, int row, const int32_t* blocks, int tiles, size_t in_block);

}  // namespace vdbcloud::plane_kernel
