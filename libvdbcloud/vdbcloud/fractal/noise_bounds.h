#pragma once
// Bounds of noise over blocks of voxels, which settle most blocks of a cloud. Private to fractal/.
#include "vdbcloud/fft/real_transform.h"

#include <vector>

namespace vdbcloud {

/// Edge of a block [voxels].
inline constexpr int block_edge = 8;
/// Noise is clamped to +- this, as bounds are needed [standard deviations].
inline constexpr float most_noise = 4;

/// Least and most noise, clamped, of every block of the domain. Threads: made by all of TBB's, then immutable.
class NoiseBounds {
public:
    struct Range {
        float low, high;
    };
    explicit NoiseBounds(const fft::RealField<float>& noise);

    /// Bounds over the voxels of the block at `origin` moved by `shift` along the first two axes, around the ends.
    Range over(const Vec3i& origin, const Vec3i& shift) const;

private:
    void measure(const fft::RealField<float>& noise, int block_x, int block_y);

    Vec3i size_, blocks_;
    std::vector<Range> ranges_;
};

}  // namespace vdbcloud
