#include "vdbcloud/scatter/boundary.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double radius = 3;         // of the gradient's window [longest edge of a voxel]
constexpr double samples = 2;        // most samples of the window for each such edge, along shorter edges
constexpr double least_edge = 1e-6;  // of a voxel as the window sees it, over the longest: keeps integers in range
constexpr int near = 2;              // half-width of the window of faces [voxels]
constexpr double cancelled = 0.47;   // of a half-space's gradient; a surface on one side has more
constexpr int most_run = 512;        // voxels of a thin part along an axis that are counted

/// The gradient's window: voxels within a ball [world], seen from its middle voxel.
class Window {
public:
    struct Tap {
        Vec3i voxel;
        Vec3d moment;  // weight x place over the window's own second moment [1/longest edge]
    };

    explicit Window(const Vec3d& spacing)
    {
        const double longest = std::max({spacing[0], spacing[1], spacing[2]});
        Vec3d edge;
        Vec3i step, last;
        for (int a = 0; a < 3; ++a) {
            edge[a] = std::max(spacing[a] / longest, least_edge);
            step[a] = std::max(1, int(std::lround(1 / (samples * edge[a]))));
            last[a] = int(std::ceil(radius / (step[a] * edge[a]))) - 1;
            reach_[a] = last[a] * step[a];
        }
        Vec3d second(0, 0, 0);
        for (int i = -last[0]; i <= last[0]; ++i)
            for (int j = -last[1]; j <= last[1]; ++j)
                for (int k = -last[2]; k <= last[2]; ++k) {
                    const Vec3i voxel(i * step[0], j * step[1], k * step[2]);
                    const Vec3d place(voxel[0] * edge[0], voxel[1] * edge[1], voxel[2] * edge[2]);
                    const double u = 1 - place.dot(place) / (radius * radius);
                    if (u <= 0) continue;
                    taps_.push_back({voxel, u * u * place});
                    second += u * u * place * place;
                }
        for (Tap& tap : taps_) {
            tap.moment *= second[0] / second;
            for (int a = 0; a < 3; ++a)
                if (tap.voxel[a] > 0) half_space_ += tap.moment[a] / 3;
        }
    }
    const std::vector<Tap>& taps() const { return taps_; }
    const Vec3i& reach() const { return reach_; }  ///< [voxels]
    /// Length of the gradient at the flat surface of a half-space of density 1, the mean over surfaces across the axes.
    double half_space() const { return half_space_; }

private:
    std::vector<Tap> taps_;
    Vec3i reach_;
    double half_space_ = 0;
};

/// The blocks about a block, each looked up when it is first asked for.
class Surroundings {
public:
    Surroundings(const Blocks& blocks, const Vec3i& reach) : blocks_(blocks)
    {
        for (int a = 0; a < 3; ++a) about_[a] = (reach[a] + Blocks::edge - 1) / Blocks::edge;
        const double all = (2.0 * about_[0] + 1) * (2.0 * about_[1] + 1) * (2.0 * about_[2] + 1);
        if (all <= most) found_.resize(size_t(all));
    }
    void move_to(size_t block)
    {
        middle_ = block;
        std::fill(found_.begin(), found_.end(), unknown);
    }
    /// The slot of a voxel given relative to the middle block.
    size_t slot(const Vec3i& voxel)
    {
        const Vec3i at(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3);
        return size_t(block(at)) * Blocks::size + size_t((voxel[0] & 7) * 64 + (voxel[1] & 7) * 8 + (voxel[2] & 7));
    }

private:
    int32_t block(const Vec3i& at)
    {
        if (found_.empty()) return blocks_.find(blocks_.at(middle_) + at);
        int32_t& found = found_[size_t(
            ((at[0] + about_[0]) * (2 * about_[1] + 1) + at[1] + about_[1]) * (2 * about_[2] + 1) + at[2] + about_[2])];
        if (found == unknown) found = blocks_.find(blocks_.at(middle_) + at);
        return found;
    }

    static constexpr int32_t unknown = -1;
    static constexpr double most = 1 << 15;  // blocks in the table
    const Blocks& blocks_;
    size_t middle_ = 0;
    Vec3i about_;
    std::vector<int32_t> found_;
};

/// First moments of the density about voxels: the direction of its gradient in the axes of the index space, up to a
/// positive factor. The densities that a block's windows see lie together in one box.
class Gradients {
public:
    Gradients(const std::vector<float>& density, const Window& window, Surroundings& around)
        : density_(density), window_(window), around_(around)
    {
        double all = 1;
        for (int a = 0; a < 3; ++a) {
            size_[a] = Blocks::edge + 2 * window.reach()[a];
            all *= size_[a];
        }
        if (all > most) return;
        box_.resize(size_t(all));
        for (const Window::Tap& tap : window.taps()) offset_.push_back(place(tap.voxel) - place(Vec3i(0)));
    }

    Vec3d operator()(size_t in_block)
    {
        const Vec3i middle(int(in_block / 64), int(in_block / 8 % 8), int(in_block % 8));
        Vec3d g(0, 0, 0);
        if (box_.empty()) {
            for (const Window::Tap& tap : window_.taps())
                g += double(density_[around_.slot(middle + tap.voxel)]) * tap.moment;
            return g;
        }
        if (!filled_) fill();
        const float* at = box_.data() + place(middle);
        for (size_t n = 0; n < offset_.size(); ++n) g += double(at[offset_[n]]) * window_.taps()[n].moment;
        return g;
    }

private:
    /// Of a voxel, relative to the block, in the box.
    std::ptrdiff_t place(const Vec3i& voxel) const
    {
        const Vec3i p = voxel + window_.reach();
        return (std::ptrdiff_t(p[0]) * size_[1] + p[1]) * size_[2] + p[2];
    }
    void fill()
    {
        filled_ = true;
        const Vec3i& reach = window_.reach();
        float* to = box_.data();
        for (int i = -reach[0]; i < Blocks::edge + reach[0]; ++i)
            for (int j = -reach[1]; j < Blocks::edge + reach[1]; ++j)
                for (int k = -reach[2]; k < Blocks::edge + reach[2];) {  // as far as one block reaches
                    const int end = std::min((k & ~7) + 8, Blocks::edge + reach[2]);
                    const float* from = density_.data() + around_.slot(Vec3i(i, j, k));
                    to = std::copy(from, from + (end - k), to);
                    k = end;
                }
    }

    static constexpr double most = 1 << 14;  // voxels in the box
    const std::vector<float>& density_;
    const Window& window_;
    Surroundings& around_;
    Vec3i size_;
    bool filled_ = false;
    std::vector<float> box_;
    std::vector<std::ptrdiff_t> offset_;
};

/// Axes along which a body is thinner than the longest edge of a voxel: the window of the gradient sees both sides at
/// once, and their gradients cancel.
class ThinAxes {
public:
    explicit ThinAxes(const VoxelIndex& index) : blocks_(index.blocks())
    {
        const Vec3d h = index.spacing();
        const double longest = std::max({h[0], h[1], h[2]});
        for (int a = 0; a < 3; ++a) most_[a] = int(std::min(longest / h[a] * (1 + 1e-9), double(most_run)));
    }
    bool thin(size_t slot) const { return thin(slot, 0) || thin(slot, 1) || thin(slot, 2); }

private:
    bool thin(size_t slot, int axis) const
    {
        int run = 1;
        for (int up = 0; up < 2; ++up)
            for (size_t at = blocks_.neighbour(slot, 2 * axis + up); blocks_.active(at) && run <= most_[axis];
                 at = blocks_.neighbour(at, 2 * axis + up))
                ++run;
        return run <= most_[axis];
    }

    const Blocks& blocks_;
    Vec3i most_;  // voxels
};

/// Exposed faces, bits by Blocks::Face, of each slot.
std::vector<uint8_t> faces_of(const Blocks& blocks)
{
    std::vector<uint8_t> faces(blocks.slots(), 0);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            for (int face = 0; face < 6 && blocks.active(slot); ++face)
                if (!blocks.active(blocks.neighbour(slot, face))) faces[slot] |= uint8_t(1 << face);
    });
    return faces;
}

/// |components| of the normal by the area of the exposed faces about a voxel: of a flat piece
/// of surface, the faces across an axis have the area |n_a| times that of the piece. Both sides of a thin body count.
Vec3d normal_of_faces(const VoxelIndex& index, const std::vector<uint8_t>& faces, Surroundings& around, size_t in_block)
{
    const Vec3i middle(int(in_block / 64), int(in_block / 8 % 8), int(in_block % 8));
    const Vec3d h = index.spacing();
    Vec3d sum(0, 0, 0);
    for (int i = -near; i <= near; ++i)
        for (int j = -near; j <= near; ++j)
            for (int k = -near; k <= near; ++k) {
                const double u = 1 - (i * i + j * j + k * k) / double((near + 1) * (near + 1));
                const uint8_t there = u > 0 ? faces[around.slot(middle + Vec3i(i, j, k))] : uint8_t(0);
                for (int face = 0; face < 6; ++face)
                    if (there >> face & 1) sum[face / 2] += u * u / h[face / 2];  // area over the voxel's volume
            }
    return sum.unit();
}

}  // namespace

std::vector<ExposedVoxel> exposed_voxels(const VoxelIndex& index, const std::vector<float>& density)
{
    const Blocks& blocks = index.blocks();
    std::vector<std::vector<ExposedVoxel>> found(blocks.count());
    const Window window(index.spacing());
    const ThinAxes axes(index);
    const std::vector<uint8_t> faces = faces_of(blocks);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        Surroundings around(blocks, window.reach());
        around.move_to(b);
        Gradients gradient(density, window, around);
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
            if (!faces[slot]) continue;
            ExposedVoxel voxel{uint32_t(slot), faces[slot], {1, 1, 1}, 0, 0};
            const Vec3d g = gradient(slot % 512);
            if (g.length() > 1e-6 * density[slot]) {
                const bool cancels = g.length() < cancelled * window.half_space() * density[slot] && axes.thin(slot);
                const Vec3d n = cancels ? normal_of_faces(index, faces, around, slot % 512) : g.unit();
                voxel.falling = cancels ? 0 : 8;  // the faces have no sign
                for (int a = 0; a < 3; ++a) {
                    voxel.weight[a] = float(std::abs(n[a]));
                    voxel.falling |= uint8_t((g[a] < 0) << a);
                }
            }
            found[b].push_back(voxel);
        }
    });
    size_t count = 0;
    for (const auto& part : found) count += part.size();
    std::vector<ExposedVoxel> all;
    all.reserve(count);
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace vdbcloud
