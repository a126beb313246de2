#include "vdbcloud/solve/multigrid.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/coarsening.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr size_t direct_size = 256;  // unknowns that the Cholesky factors of the coarsest level may have
constexpr size_t most_levels = 40;
// Chebyshev of the fourth kind for the spectrum [0, 2]: z1 = 4/3 r/2, z2 = z1/5 + 12/5 r/2.
constexpr float first_step = 2.0f / 3, keep = 0.2f, second_step = 1.2f;

#define VDBCLOUD_CLONES __attribute__((target_clones("avx2", "default")))

/// Both smoothing steps from a zero guess, in one pass.
VDBCLOUD_CLONES void smooth_from_zero(const Faces& a, const float* inverse, const float* b, float* x, size_t block)
{
    alignas(64) float pad[pad_size], lower_z[512];
    load_padded(a.neighbours[block], block, pad,
                [=](size_t slot) __attribute__((always_inline)) { return first_step * inverse[slot] * b[slot]; });
    load_lower_z(a, block, lower_z);
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const size_t row = block * 512 + i * 64 + j * 8;
            const float* v = pad + padded(i, j, 0);
            float product[8];
            row_apply(row_faces(a, block, lower_z, i, j), v, product);
            for (int k = 0; k < 8; ++k)
                x[row + k] = (1 + keep) * v[k] + second_step * inverse[row + k] * (b[row + k] - product[k]);
        }
}

/// The first step from x to y; with `second`, the second step from x, the first step's result, whose start is in y.
template<bool second>
VDBCLOUD_INLINE void smooth_rows(const Faces& a, const float* inverse, const float* b, const float* x, float* y,
                                 size_t block)
{
    alignas(64) float pad[pad_size], lower_z[512];
    load_padded(a.neighbours[block], block, pad, [=](size_t slot) __attribute__((always_inline)) { return x[slot]; });
    load_lower_z(a, block, lower_z);
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const size_t row = block * 512 + i * 64 + j * 8;
            const float* v = pad + padded(i, j, 0);
            float product[8];
            row_apply(row_faces(a, block, lower_z, i, j), v, product);
            for (int k = 0; k < 8; ++k) {
                const float step = inverse[row + k] * (b[row + k] - product[k]);
                y[row + k] = second ? v[k] + keep * (v[k] - y[row + k]) + second_step * step : v[k] + first_step * step;
            }
        }
}

VDBCLOUD_CLONES void smooth_first(const Faces& a, const float* inverse, const float* b, const float* x, float* y,
                                  size_t block)
{
    smooth_rows<false>(a, inverse, b, x, y, block);
}

VDBCLOUD_CLONES void smooth_second(const Faces& a, const float* inverse, const float* b, const float* x, float* y,
                                   size_t block)
{
    smooth_rows<true>(a, inverse, b, x, y, block);
}

/// b - A x summed over groups of 2x2x2: 64 values a block.
VDBCLOUD_CLONES void restrict_residual(const Faces& a, const float* b, const float* x, float* sums, size_t block)
{
    alignas(64) float pad[pad_size], lower_z[512];
    load_padded(a.neighbours[block], block, pad, [=](size_t slot) __attribute__((always_inline)) { return x[slot]; });
    load_lower_z(a, block, lower_z);
    float* to = sums + block * 64;
    for (int i = 0; i < 64; ++i) to[i] = 0;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const size_t row = block * 512 + i * 64 + j * 8;
            float product[8];
            row_apply(row_faces(a, block, lower_z, i, j), pad + padded(i, j, 0), product);
            for (int k = 0; k < 4; ++k)
                to[(i / 2) * 16 + (j / 2) * 4 + k] +=
                    (b[row + 2 * k] - product[2 * k]) + (b[row + 2 * k + 1] - product[2 * k + 1]);
        }
}

/// Adds to a block of x the coarse values of its octant, each to its group.
VDBCLOUD_CLONES void prolong(const float* octant, float* x)
{
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
            for (int k = 0; k < 8; ++k) x[i * 64 + j * 8 + k] += octant[(i / 2) * 64 + (j / 2) * 8 + k / 2];
}

size_t corner_of(int octant) { return size_t((octant >> 2) * 256 + (octant >> 1 & 1) * 32 + (octant & 1) * 4); }

/// 1 / diagonal, 0 where there is none.
std::vector<float> inverse_diagonal(const Stencil& a)
{
    const Blocks& blocks = *a.blocks;
    std::vector<float> inverse(blocks.slots(), 0.0f);
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t slot = first * 512; slot < last * 512; ++slot) {
            double diagonal = a.extra[slot];
            for (int axis = 0; axis < 3; ++axis)
                diagonal += double(a.face[axis][slot]) + a.face[axis][blocks.neighbour(slot, 2 * axis)];
            if (diagonal > 0) inverse[slot] = float(1 / diagonal);
        }
    });
    return inverse;
}

}  // namespace

struct Multigrid::Level {
    Blocks own_blocks;                     // of the levels below the first
    std::unique_ptr<Stencil> own_stencil;  // the same
    const Stencil* a = nullptr;
    std::vector<float> inverse, b, x, other, sums;
    CoarseMap map;   // to the next level
    int visits = 1;  // of the next level in one visit of this one

    const Blocks& blocks() const { return *a->blocks; }

    template<typename F>
    void each_block(const F& f)
    {
        for_ranges(blocks().count(), [&](size_t first, size_t last) {
            for (size_t block = first; block < last; ++block) f(block);
        });
    }
};

/// Cholesky factors of the coarsest level, in double, row by row.
struct Multigrid::Coarsest {
    std::vector<size_t> slots;
    std::vector<double> factor, work;

    explicit Coarsest(const Stencil& a)
    {
        const Blocks& blocks = *a.blocks;
        std::vector<int> number(blocks.slots(), -1);
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
            if (blocks.active(slot)) {
                number[slot] = int(slots.size());
                slots.push_back(slot);
            }
        const size_t n = slots.size();
        factor.assign(n * n, 0.0);
        work.resize(n);
        for (size_t i = 0; i < n; ++i) {
            factor[i * n + i] += a.extra[slots[i]];
            for (int axis = 0; axis < 3; ++axis) {
                const double c = a.face[axis][slots[i]];
                if (!(c > 0)) continue;
                const size_t j = size_t(number[blocks.neighbour(slots[i], 2 * axis + 1)]);
                factor[i * n + i] += c;
                factor[j * n + j] += c;
                factor[i * n + j] -= c;
                factor[j * n + i] -= c;
            }
        }
        for (size_t j = 0; j < n; ++j) {
            const double before = factor[j * n + j];
            double pivot = before;
            for (size_t k = 0; k < j; ++k) pivot -= factor[j * n + k] * factor[j * n + k];
            // A singular matrix (nothing absorbs or leaves) ends in a zero pivot: that unknown is then held at 0.
            pivot = pivot > 1e-13 * before ? std::sqrt(pivot) : 1e150;
            factor[j * n + j] = pivot;
            for (size_t i = j + 1; i < n; ++i) {
                double value = factor[i * n + j];
                for (size_t k = 0; k < j; ++k) value -= factor[i * n + k] * factor[j * n + k];
                factor[i * n + j] = value / pivot;
            }
        }
    }

    void solve(const std::vector<float>& b, std::vector<float>& x)
    {
        const size_t n = slots.size();
        for (size_t i = 0; i < n; ++i) {
            double value = b[slots[i]];
            for (size_t k = 0; k < i; ++k) value -= factor[i * n + k] * work[k];
            work[i] = value / factor[i * n + i];
        }
        for (size_t i = n; i-- > 0;) {
            work[i] /= factor[i * n + i];
            for (size_t k = 0; k < i; ++k) work[k] -= factor[i * n + k] * work[i];
            x[slots[i]] = float(work[i]);
        }
    }
};

Multigrid::Multigrid(const Stencil& fine, const std::vector<float>* boundary)
{
    levels_.push_back(std::make_unique<Level>());
    levels_[0]->a = &fine;
    std::vector<float> outside = boundary ? *boundary : std::vector<float>(fine.extra.size(), 0.0f);
    double visits = 1;  // of the current level in one cycle
    while (true) {
        Level& level = *levels_.back();
        const size_t slots = level.blocks().slots();
        level.x.assign(slots, 0.0f);
        level.b.assign(slots, 0.0f);
        if (level.blocks().active_count() <= direct_size || levels_.size() >= most_levels) break;
        level.inverse = inverse_diagonal(*level.a);
        level.other.assign(slots, 0.0f);
        level.sums.assign(slots / 8, 0.0f);

        auto next = std::make_unique<Level>();
        next->own_blocks = coarse_blocks(level.blocks(), level.map);
        next->own_stencil = std::make_unique<Stencil>(next->own_blocks);
        next->a = next->own_stencil.get();
        std::vector<float> coarse_outside;
        coarse_stencil(*level.a, outside, level.map, *next->own_stencil, coarse_outside);
        outside = std::move(coarse_outside);
        const bool small = next->blocks().count() * 5 <= level.blocks().count() * 3 || next->blocks().count() <= 2;
        level.visits = small && visits < 64 ? 2 : 1;
        visits *= level.visits;
        levels_.push_back(std::move(next));
    }
    if (levels_.back()->blocks().active_count() <= 4 * direct_size)
        coarsest_ = std::make_unique<Coarsest>(*levels_.back()->a);
    else
        levels_.back()->inverse = inverse_diagonal(*levels_.back()->a);
}

Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;

int Multigrid::levels() const { return int(levels_.size()); }

size_t Multigrid::bytes() const
{
    size_t total = 0;
    for (const auto& level : levels_) {
        const auto& l = *level;
        total += sizeof(float) * (l.inverse.size() + l.b.size() + l.x.size() + l.other.size() + l.sums.size());
        total += l.map.parent.size() * 5 + l.map.children.size() * 32;
        if (l.own_stencil) total += l.own_stencil->bytes() + l.own_blocks.count() * 100;
    }
    return total;
}

const std::vector<float>& Multigrid::cycle(const std::vector<double>& residual)
{
    Level& fine = *levels_[0];
    fine.each_block([&](size_t block) {
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot) fine.b[slot] = float(residual[slot]);
    });
    visit(0, true);
    return fine.x;
}

void Multigrid::visit(size_t number, bool zero_guess)
{
    Level& level = *levels_[number];
    if (number + 1 == levels_.size()) {
        if (coarsest_)
            coarsest_->solve(level.b, level.x);
        else
            for (size_t slot = 0; slot < level.x.size(); ++slot) level.x[slot] = level.inverse[slot] * level.b[slot];
        return;
    }
    const Faces a = faces_of(*level.a);
    const float *inverse = level.inverse.data(), *b = level.b.data();
    float *x = level.x.data(), *y = level.other.data();
    const auto smooth = [&] {
        level.each_block([&](size_t block) { smooth_first(a, inverse, b, x, y, block); });
        level.each_block([&](size_t block) { smooth_second(a, inverse, b, y, x, block); });
    };
    if (zero_guess)
        level.each_block([&](size_t block) { smooth_from_zero(a, inverse, b, x, block); });
    else
        smooth();

    Level& coarse = *levels_[number + 1];
    level.each_block([&](size_t block) { restrict_residual(a, b, x, level.sums.data(), block); });
    coarse.each_block([&](size_t block) {
        for (int o = 0; o < 8; ++o) {
            const float* from = level.sums.data() + size_t(level.map.children[block][o]) * 64;
            float* to = coarse.b.data() + block * 512 + corner_of(o);
            for (int i = 0; i < 64; ++i) to[(i >> 4) * 64 + (i >> 2 & 3) * 8 + (i & 3)] = from[i];
        }
    });
    for (int k = 0; k < level.visits; ++k) visit(number + 1, k == 0);
    level.each_block([&](size_t block) {
        prolong(coarse.x.data() + size_t(level.map.parent[block]) * 512 + corner_of(level.map.octant[block]), x + block * 512);
    });
    smooth();
}

}  // namespace vdbcloud
