#pragma once
// Light that a voxel's centre receives from the emitting voxels about it. Private to scatter/.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// Emission of the 3^3 voxels about a point, and extinction of the 5^3 voxels, as seen along a fixed set of rays from
/// the middle. A value lies at (x * 5 + y) * 5 + z, each from 0 to 4.
///
/// Emission and extinction are trilinear; emission falls to 0 two voxels from the middle. Along a ray both are linear
/// between samples, four from one plane of voxel centres to the next. Without a factor 1 / r^2 the voxel's own light is
/// as exact as that of its neighbours. With emission in proportion to extinction and both uniform, the radiance along a
/// ray is j / sigma (1 - e^-tau), exactly.
class NearEmission {
public:
    static constexpr int width = 5, nodes = width * width * width;
    using Field = std::array<float, nodes>;

    /// `spacing`: edges of a voxel [world unit]. Light is expanded in `terms` harmonics about the index axes.
    NearEmission(const Vec3d& spacing, int degree);

    /// Adds the moments of radiance of one channel; emission outside the inner 3^3 voxels counts as 0.
    void add(const Field& emission, const Field& sigma, double* moments) const;

private:
    static constexpr int samples = 8;
    /// A sample of the trilinear interpolant.
    struct Sample {
        std::array<int, 8> node;
        std::array<float, 8> weight;
    };
    struct Ray {
        std::array<Sample, samples> sample;  // outwards; the middle is not among them
        double step;                         // from sample to sample [world unit]
    };
    int terms_;
    std::vector<Ray> rays_;
    std::vector<double> basis_;  // ray by ray: weight times Y_lm along the light's way
};

}  // namespace vdbcloud
