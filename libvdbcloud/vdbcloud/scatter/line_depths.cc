// Lines through the cells of a medium that ends on all sides, block by block: emptiness costs nothing.
#include "vdbcloud/scatter/beam.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbcloud {

namespace {

constexpr int tile_bits = 5;
constexpr int64_t tile = 1 << tile_bits;  // lines along the edge of a tile
constexpr int strides[3] = {64, 8, 1};

/// Index axes turned so that lines run along w with slopes |mu|, |mv| <= 1. Line (i, j) is at u = i + at_u + mu w and
/// v = j + at_v + mv w, each times the spacing of lines [voxels]. At slope 0 it lies within a column of voxels, off the
/// faces.
struct Lines {
    static constexpr double at_u = 0.21, at_v = -0.17;
    int u, v, w;
    double mu, mv;
    double length;  ///< world units per unit of w
    double spacing = 1;

    Lines(const VoxelIndex& index, const Vec3d& direction)
    {
        Vec3d s;
        for (int a = 0; a < 3; ++a) s[a] = direction.dot(index.axis(a)) / index.spacing()[a];
        w = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(s[a]) > std::abs(s[w])) w = a;
        u = (w + 1) % 3;
        v = (w + 2) % 3;
        mu = s[u] / s[w];
        mv = s[v] / s[w];
        length = 1 / std::abs(s[w]);
        if (mu == 0 && mv == 0) return;  // exact
        // Bodies of few blocks take closer lines: some ten thousands of pieces within blocks.
        while (double(index.blocks().count()) < 512 * spacing * spacing) spacing /= 2;
    }
};

/// The lines first..last along one axis that can meet a block.
struct Range {
    int64_t first, last;
    Range(int block, int block_w, double at, double slope, double spacing)
    {
        const double low = 8.0 * block - 0.5, from = slope * (8.0 * block_w - 0.5), to = slope * (8.0 * block_w + 7.5);
        first = int64_t(std::floor((low - std::max(from, to)) / spacing - at));
        last = int64_t(std::ceil((low + 8 - std::min(from, to)) / spacing - at));
    }
};

/// Part of a line within a block, in voxels from the block's corner: u = u0 + mu t, v = v0 + mv t, w = t.
struct Chord {
    double u0, v0, t0 = 0, t1 = 8;

    Chord(const Lines& lines, const Vec3i& block, int64_t i, int64_t j)
    {
        const double w = 8.0 * block[lines.w] - 0.5;
        u0 = lines.spacing * (double(i) + lines.at_u) + lines.mu * w - (8.0 * block[lines.u] - 0.5);
        v0 = lines.spacing * (double(j) + lines.at_v) + lines.mv * w - (8.0 * block[lines.v] - 0.5);
        clip(u0, lines.mu);
        clip(v0, lines.mv);
    }

private:
    void clip(double start, double slope)
    {
        if (slope == 0) {
            if (start < 0 || start >= 8) t1 = t0;
            return;
        }
        const double p = -start / slope, q = (8 - start) / slope;
        t0 = std::max(t0, std::min(p, q));
        t1 = std::min(t1, std::max(p, q));
    }
};

/// Where start + slope t crosses a wall of cells between `from` and `to`; `to` where it crosses none. |slope| is at
/// most 1 and the two are at most 1 apart, so there is one wall at most.
double wall_between(double start, double slope, double from, double to)
{
    const double p = start + slope * from, q = start + slope * to, wall = std::floor(std::min(p, q)) + 1;
    return wall < std::max(p, q) ? std::clamp((wall - start) / slope, from, to) : to;
}

/// Sum of density x length along a chord [density x unit of w].
double depth_in(const float* density, const Lines& lines, const Chord& chord)
{
    const auto cell = [](double x) { return std::clamp(int(x), 0, 7); };
    double depth = 0;
    for (int k = cell(chord.t0); k < 8 && k < chord.t1; ++k) {
        const double from = std::max(chord.t0, double(k)), to = std::min(chord.t1, k + 1.0);
        if (!(from < to)) continue;
        const double wall_u = wall_between(chord.u0, lines.mu, from, to),
                     wall_v = wall_between(chord.v0, lines.mv, from, to);
        const double cut[4] = {from, std::min(wall_u, wall_v), std::max(wall_u, wall_v), to};
        for (int n = 0; n < 3; ++n) {
            if (!(cut[n] < cut[n + 1])) continue;
            const double middle = (cut[n] + cut[n + 1]) / 2;
            const int at = k * strides[lines.w] + cell(chord.u0 + lines.mu * middle) * strides[lines.u] +
                           cell(chord.v0 + lines.mv * middle) * strides[lines.v];
            depth += double(density[at]) * (cut[n + 1] - cut[n]);
        }
    }
    return depth;
}

/// A block and a tile whose lines may meet it.
struct Visit {
    int64_t tu, tv;
    size_t block;
    bool operator<(const Visit& o) const { return tu != o.tu ? tu < o.tu : tv != o.tv ? tv < o.tv : block < o.block; }
};

}  // namespace

LineDepths line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light)
{
    const Lines lines(index, -*light->common_direction());
    const Blocks& blocks = index.blocks();
    LineDepths result;
    result.area = lines.spacing * lines.spacing * index.spacing()[lines.u] * index.spacing()[lines.v] *
                  std::abs(light->common_direction()->dot(index.axis(lines.w)));
    const auto range_u = [&](const Vec3i& at) {
        return Range(at[lines.u], at[lines.w], lines.at_u, lines.mu, lines.spacing);
    };
    const auto range_v = [&](const Vec3i& at) {
        return Range(at[lines.v], at[lines.w], lines.at_v, lines.mv, lines.spacing);
    };
    std::vector<Visit> visits;
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Range u = range_u(blocks.at(b)), v = range_v(blocks.at(b));
        for (int64_t tu = u.first >> tile_bits; tu <= u.last >> tile_bits; ++tu)
            for (int64_t tv = v.first >> tile_bits; tv <= v.last >> tile_bits; ++tv) visits.push_back({tu, tv, b});
    }
    std::sort(visits.begin(), visits.end());
    std::vector<size_t> begin;  // of each tile's visits
    for (size_t n = 0; n < visits.size(); ++n)
        if (n == 0 || visits[n].tu != visits[n - 1].tu || visits[n].tv != visits[n - 1].tv) begin.push_back(n);
    begin.push_back(visits.size());

    std::vector<std::vector<double>> found(begin.size() - 1);
    tbb::parallel_for(size_t(0), found.size(), [&](size_t of) {
        std::vector<double> depth(size_t(tile * tile), 0.0);
        const int64_t i0 = visits[begin[of]].tu * tile, j0 = visits[begin[of]].tv * tile;
        for (size_t n = begin[of]; n < begin[of + 1]; ++n) {
            const size_t b = visits[n].block;
            const Range u = range_u(blocks.at(b)), v = range_v(blocks.at(b));
            for (int64_t i = std::max(u.first, i0); i <= std::min(u.last, i0 + tile - 1); ++i)
                for (int64_t j = std::max(v.first, j0); j <= std::min(v.last, j0 + tile - 1); ++j) {
                    const Chord chord(lines, blocks.at(b), i, j);
                    if (chord.t0 < chord.t1)
                        depth[size_t((i - i0) * tile + j - j0)] +=
                            lines.length * depth_in(density.data() + b * Blocks::size, lines, chord);
                }
        }
        std::copy_if(depth.begin(), depth.end(), std::back_inserter(found[of]), [](double d) { return d > 0; });
    });
    for (const auto& part : found) result.depth.insert(result.depth.end(), part.begin(), part.end());
    return result;
}

}  // namespace vdbcloud
