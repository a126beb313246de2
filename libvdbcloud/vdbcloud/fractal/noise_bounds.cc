#include "vdbcloud/fractal/noise_bounds.h"

#include "vdbcloud/core/clones.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace vdbcloud {

namespace {

constexpr int B = block_edge;

/// The blocks along an axis that voxels first + shift .. of a block lie in, around the end; returns how many.
int blocks_touched(int first, int shift, int size, int* out)
{
    int count = 0;
    for (int t = 0; t < B && first + t < size; ++t) {
        const int at = first + t + shift, block = (at >= size ? at - size : at) / B;
        if (count == 0 || out[count - 1] != block) out[count++] = block;
    }
    return count;
}

}  // namespace

NoiseBounds::NoiseBounds(const fft::RealField<float>& noise) : size_(noise.size())
{
    for (int d = 0; d < 3; ++d) blocks_[d] = (size_[d] + B - 1) / B;
    ranges_.resize(size_t(blocks_.product()));
    tbb::parallel_for(0, blocks_[0], [&](int i) {
        for (int j = 0; j < blocks_[1]; ++j) measure(noise, i, j);
    });
}

NoiseBounds::Range NoiseBounds::over(const Vec3i& o, const Vec3i& shift) const
{
    int i[B], j[B];
    const int ni = blocks_touched(o[0], shift[0], size_[0], i), nj = blocks_touched(o[1], shift[1], size_[1], j);
    Range out{most_noise, -most_noise};
    for (int a = 0; a < ni; ++a)
        for (int b = 0; b < nj; ++b) {
            const auto& r = ranges_[size_t((i[a] * blocks_[1] + j[b]) * blocks_[2] + o[2] / B)];
            out = {std::min(out.low, r.low), std::max(out.high, r.high)};
        }
    return out;
}

VDBCLOUD_CLONES void NoiseBounds::measure(const fft::RealField<float>& noise, int bi, int bj)
{
    const int whole = size_[2] / B;
    Range* out = &ranges_[size_t((bi * blocks_[1] + bj) * blocks_[2])];
    const int rows = std::min(B, size_[0] - bi * B), columns = std::min(B, size_[1] - bj * B);
    for (int k = 0; k < blocks_[2]; ++k) {
        const int width = k < whole ? B : size_[2] - k * B;
        float low[B], high[B];
        for (int l = 0; l < B; ++l) low[l] = most_noise, high[l] = -most_noise;
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) {
                const float* row = noise.row(bi * B + i, bj * B + j) + k * B;
                if (width == B) {
                    for (int l = 0; l < B; ++l) {
                        low[l] = row[l] < low[l] ? row[l] : low[l];
                        high[l] = row[l] > high[l] ? row[l] : high[l];
                    }
                } else {
                    for (int l = 0; l < width; ++l)
                        low[l] = std::min(low[l], row[l]), high[l] = std::max(high[l], row[l]);
                }
            }
        out[k] = {std::max(-most_noise, *std::min_element(low, low + B)),
                  std::min(most_noise, *std::max_element(high, high + B))};
    }
}

}  // namespace vdbcloud
