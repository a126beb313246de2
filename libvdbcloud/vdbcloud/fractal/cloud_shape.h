#pragma once
// Noise and an envelope become a density: the shaping of a fractal cloud.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/fft/real_transform.h"
#include "vdbcloud/fractal/envelope.h"

#include <optional>
#include <vector>

namespace vdbcloud {

/// How noise n(x) (of about unit variance) and the depth D(x) of an envelope make a density:
///
///     w(x) = warp (n(x + s1), n(x + s2), n(x + s3))       displacement by shifted copies of the noise
///     v(x) = D(x + w(x)) + roughness b(n(x)) - t,         b(n) = (1 - billow) n + billow (2 |n| - mean)
///     density = smoothstep(v / edge) in 0..1
///
/// with n held within +-4 and the shifts, in voxels rounded down, of (1/3, 1/2, 0), (1/2, 1/5, 0) and (5/6, 3/4, 0) of
/// the size. The density is 0 below the envelope's base and fades towards the faces of the
/// domain. Without a coverage t is 0 and noise carries the surface in and out; with one, t is chosen so that
/// this fraction of the envelope is filled, and nothing lies beyond the envelope as displaced. Lengths here
/// are fractions of the domain's longest side.
struct ShapeOptions {
    double roughness = 0.012;        ///< how far noise moves the surface, per standard deviation; 0..10
    double warp = 0.012;             ///< how far noise displaces the envelope, per standard deviation; 0..1
    double billow = 0.3;             ///< 0: noise as it is, 1: its folds, round outwards and creased inwards
    double edge = 0.012;             ///< from density 0 to 1; at least 1.5 voxels are taken; 0..1
    std::optional<double> coverage;  ///< fraction of the envelope that is to hold cloud, 0..1
    int up = 1;                      ///< axis that points up: 0, 1 or 2
};

/// A sparse density: 8 x 8 x 8 voxels a block.
struct CloudBlocks {
    Vec3i size{0, 0, 0};  ///< of the domain [voxels]
    Box domain;           ///< [world]

    struct Block {
        Vec3i origin;                   ///< of its first voxel, a multiple of 8 on each axis
        const float* values = nullptr;  ///< 512 values, the third index fastest; null: 1 everywhere
    };
    std::vector<Block> blocks;                ///< every block that is not 0 everywhere, in a fixed order
    std::vector<std::vector<float>> storage;  ///< what `values` point into
    double threshold = 0;                     ///< t above [world]
};

/// Shapes a density from noise over the same domain.
///
/// Only blocks near the surface are evaluated voxel by voxel; bounds on depth and noise settle the others.
/// With coverage the threshold t is found first, as a quantile of v over an eighth of the envelope's voxels.
///
/// Threads: all of TBB's; values do not depend on them. Memory: the blocks. Throws InputError for an option
/// outside its range or an envelope without a voxel, Cancelled.
CloudBlocks shape_cloud(const fft::RealField<float>& noise, const Box& domain, const Envelope&, const ShapeOptions&,
                        const Progress& = {});

}  // namespace vdbcloud
