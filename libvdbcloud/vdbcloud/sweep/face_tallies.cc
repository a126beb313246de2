#include "vdbcloud/sweep/face_tallies.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using block_sweep::Layout;
using block_sweep::Traversal;

namespace {

/// Where slots of a block are in a layout.
struct Places {
    explicit Places(const Layout& layout)
    {
        for (int slot = 0; slot < 512; ++slot) {
            const int c[3] = {slot / 64, slot / 8 % 8, slot % 8};
            padded[slot] = Layout::first;
            row[slot] = 0;
            for (int a = 0; a < 3; ++a) {
                padded[slot] = int16_t(padded[slot] + (c[a] + 1) * layout.stride[size_t(a)]);
                row[slot] = int16_t(row[slot] + c[a] * layout.row_stride[size_t(a)]);
            }
        }
    }
    int16_t padded[512], row[512];
};

/// The four voxels, and their weights, whose centres' plane light passed half a voxel before it meets the middle of a
/// face; at most one voxel to the side, where light grazes.
struct Origin {
    Origin(const Traversal& traversal, int k, bool along, bool outward)
    {
        const int side[2] = {(k + 1) % 3, (k + 2) % 3};
        const double across = std::abs(traversal.step[traversal.axis[size_t(k)]]);
        float f[2];
        for (int n = 0; n < 2; ++n)
            f[n] = float(
                std::min(0.5 * std::abs(traversal.step[traversal.axis[size_t(side[n])]]) / std::max(across, 1e-30),
                         along ? 0.0 : 1.0));
        const auto before = [&](int n) { return -traversal.sign[size_t(n)] * traversal.stride[size_t(n)]; };
        for (int n = 0; n < 4; ++n) {
            at[n] = (along || outward ? 0 : before(k)) + (n & 1 ? before(side[0]) : 0) + (n & 2 ? before(side[1]) : 0);
            weight[n] = (n & 1 ? f[0] : 1 - f[0]) * (n & 2 ? f[1] : 1 - f[1]);
        }
    }
    float operator()(const float* radiance) const
    {
        return (weight[0] * radiance[at[0]] + weight[1] * radiance[at[1]]) +
               (weight[2] * radiance[at[2]] + weight[3] * radiance[at[3]]);
    }
    int at[4];
    float weight[4];
};

}  // namespace

FaceTallies::FaceTallies(size_t blocks, const std::vector<SweepFace>& faces, bool outward_only)
    : outward_only_(outward_only), begin_(blocks * 6 + 1, 0), number_(faces.size()), slot_(faces.size())
{
    const auto side = [](const SweepFace& face) { return size_t(face.slot / 512) * 6 + face.face; };
    for (const SweepFace& face : faces) ++begin_[side(face) + 1];
    for (size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
    std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (size_t f = 0; f < faces.size(); ++f) {
        const uint32_t at = next[side(faces[f])]++;
        number_[at] = uint32_t(f);
        slot_[at] = uint16_t(faces[f].slot % 512);
    }
    clear();
}

void FaceTallies::clear()
{
    for (auto& sum : sum_) sum.assign(number_.size(), 0.0f);
}

void FaceTallies::add(const Traversal& traversal, int d, size_t block, const Vec3d& direction, float weight,
                      const block_sweep::Scratch& s, std::array<double, 3>* sums)
{
    static const Places natural(block_sweep::natural), turned(block_sweep::turned);
    if (!any(block)) return;
    const Places& places = traversal.layout == &block_sweep::natural ? natural : turned;
    constexpr size_t chunk = 64;
    alignas(32) float radiance[chunk], sigma[chunk], q[chunk];
    for (int k = 0; k < 3; ++k)
        for (int upper = 0; upper < 2; ++upper) {
            const int axis = traversal.axis[size_t(k)], face = 2 * axis + upper;
            const size_t end = begin_[block * 6 + size_t(face) + 1];
            if (begin_[block * 6 + size_t(face)] == end) continue;
            const bool along = direction[axis] == 0, outward = !along && (upper ? 1 : -1) == traversal.sign[size_t(k)];
            if (outward_only_ && !outward) continue;
            const Origin origin(traversal, k, along, outward);
            const float cosine = float(upper ? direction[axis] : -direction[axis]);
            const std::array<float, 3> factor{cosine * weight, weight, (cosine * cosine - 1.0f / 3) * weight};
            for (size_t first = begin_[block * 6 + size_t(face)]; first < end; first += chunk) {
                const size_t count = std::min(chunk, end - first);
                const uint16_t* slot = &slot_[first];
                for (size_t n = 0; n < count; ++n) radiance[n] = origin(s.padded + places.padded[slot[n]]);
                if (outward) {
                    const size_t rounded = (count + 7) / 8 * 8;
                    for (size_t n = 0; n < count; ++n) {
                        sigma[n] = s.sigma[places.row[slot[n]]];
                        q[n] = s.q[d][places.row[slot[n]]];
                    }
                    for (size_t n = count; n < rounded; ++n) radiance[n] = sigma[n] = q[n] = 0;
                    block_sweep::leave(int(rounded), radiance, sigma, q, traversal.half_exit[size_t(k)], radiance);
                }
                block_sweep::add(count, radiance, factor, {&sum_[0][first], &sum_[1][first], &sum_[2][first]});
                if (sums && outward)
                    for (size_t n = 0; n < count; ++n) (*sums)[size_t(axis)] += double(factor[0] * radiance[n]);
            }
        }
}

void FaceTallies::write(std::vector<FaceTally>& to) const
{
    to.resize(number_.size());
    for (size_t n = 0; n < number_.size(); ++n) to[number_[n]] = {sum_[0][n], sum_[1][n], sum_[2][n]};
}

size_t FaceTallies::bytes() const
{
    return begin_.size() * sizeof(uint32_t) +
           number_.size() * (sizeof(uint32_t) + sizeof(uint16_t) + 3 * sizeof(float));
}

}  // namespace vdbcloud
