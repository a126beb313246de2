#include "vdbcloud/solve/multigrid.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr size_t direct_size = 256;  // unknowns that the Cholesky factors of the coarsest level may have
constexpr size_t most_levels = 16;
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

/// y = b - A x.
VDBCLOUD_CLONES void residual_of(const Faces& a, const float* b, const float* x, float* y, size_t block)
{
    alignas(64) float pad[pad_size], lower_z[512];
    load_padded(a.neighbours[block], block, pad, [=](size_t slot) __attribute__((always_inline)) { return x[slot]; });
    load_lower_z(a, block, lower_z);
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const size_t row = block * 512 + i * 64 + j * 8;
            float product[8];
            row_apply(row_faces(a, block, lower_z, i, j), pad + padded(i, j, 0), product);
            for (int k = 0; k < 8; ++k) y[row + k] = b[row + k] - product[k];
        }
}

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

/// The finest level, on blocks.
struct Multigrid::Finest {
    const Stencil* a;
    std::vector<float> inverse, b, x, other;
    std::vector<int32_t> parent;  // of each slot, -1 if not active
    int visits = 1;
};

/// Cholesky factors of the coarsest level, in double, row by row.
struct Multigrid::Coarsest {
    std::vector<double> factor, work;

    explicit Coarsest(const GraphLevel& a) : factor(a.size() * a.size(), 0.0), work(a.size())
    {
        const size_t n = a.size();
        for (size_t i = 0; i < n; ++i) {
            factor[i * n + i] += a.extra[i];
            for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
                factor[i * n + i] += a.c[k];
                factor[i * n + size_t(a.column[k])] -= a.c[k];
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
        const size_t n = work.size();
        for (size_t i = 0; i < n; ++i) {
            double value = b[i];
            for (size_t k = 0; k < i; ++k) value -= factor[i * n + k] * work[k];
            work[i] = value / factor[i * n + i];
        }
        for (size_t i = n; i-- > 0;) {
            work[i] /= factor[i * n + i];
            for (size_t k = 0; k < i; ++k) work[k] -= factor[i * n + k] * work[i];
            x[i] = float(work[i]);
        }
    }
};

Multigrid::Multigrid(const Stencil& fine, const std::vector<float>* boundary) : finest_(std::make_unique<Finest>())
{
    const size_t slots = fine.blocks->slots();
    finest_->a = &fine;
    {
        const std::vector<float> none(boundary ? 0 : slots, 0.0f);
        levels_.push_back(coarse_level(fine, boundary ? *boundary : none, finest_->parent));
    }
    finest_->inverse = inverse_diagonal(fine);
    for (auto* v : {&finest_->b, &finest_->x, &finest_->other}) v->assign(slots, 0.0f);

    // W cycles while the work stays linear in the unknowns.
    double share = 1;
    const auto visits = [&](size_t from, size_t to) {
        const double ratio = double(to) / double(std::max<size_t>(1, from));
        const int count = ratio <= 0.2 && share < 64 ? 2 : 1;
        share *= count;
        return count;
    };
    finest_->visits = visits(fine.blocks->active_count(), levels_[0].size());
    while (levels_.back().size() > direct_size && !levels_.back().column.empty() && levels_.size() < most_levels) {
        GraphLevel next = coarse_level(levels_.back());
        visits_.push_back(visits(levels_.back().size(), next.size()));
        levels_.push_back(std::move(next));
    }
    if (levels_.back().size() <= 4 * direct_size) coarsest_ = std::make_unique<Coarsest>(levels_.back());
}

Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;

int Multigrid::levels() const { return int(levels_.size()) + 1; }

size_t Multigrid::bytes() const
{
    size_t total = sizeof(float) * (finest_->inverse.size() * 4 + finest_->parent.size());
    for (const GraphLevel& level : levels_) total += level.bytes();
    return total;
}

const std::vector<float>& Multigrid::cycle(const std::vector<double>& residual)
{
    Finest& f = *finest_;
    const size_t count = f.a->blocks->count();
    const Faces a = faces_of(*f.a);
    const auto each_block = [&](const auto& work) {
        for_ranges(count, [&](size_t first, size_t last) {
            for (size_t block = first; block < last; ++block) work(block);
        });
    };
    each_block([&](size_t block) {
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot) f.b[slot] = float(residual[slot]);
    });
    float *x = f.x.data(), *y = f.other.data();
    const float *inverse = f.inverse.data(), *b = f.b.data();
    each_block([&](size_t block) { smooth_from_zero(a, inverse, b, x, block); });
    each_block([&](size_t block) { residual_of(a, b, x, y, block); });
    GraphLevel& coarse = levels_[0];
    // Groups lie within blocks, so each block fills unknowns of its own, in a fixed order.
    std::fill(coarse.b.begin(), coarse.b.end(), 0.0f);
    each_block([&](size_t block) {
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot)
            if (f.parent[slot] >= 0) coarse.b[f.parent[slot]] += y[slot];
    });
    for (int k = 0; k < f.visits; ++k) visit(0, k == 0);
    each_block([&](size_t block) {
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot)
            if (f.parent[slot] >= 0) x[slot] += coarse.x[f.parent[slot]];
    });
    each_block([&](size_t block) { smooth_first(a, inverse, b, x, y, block); });
    each_block([&](size_t block) { smooth_second(a, inverse, b, y, x, block); });
    return f.x;
}

void Multigrid::visit(size_t number, bool zero_guess)
{
    GraphLevel& level = levels_[number];
    if (number + 1 == levels_.size()) {
        if (coarsest_) coarsest_->solve(level.b, level.x);
        else
            for (int k = 0; k < 4; ++k) level.smooth(zero_guess && k == 0);
        return;
    }
    level.smooth(zero_guess);
    level.residual();
    GraphLevel& coarse = levels_[number + 1];
    std::fill(coarse.b.begin(), coarse.b.end(), 0.0f);
    for (size_t i = 0; i < level.size(); ++i) coarse.b[level.parent[i]] += level.other[i];
    for (int k = 0; k < visits_[number]; ++k) visit(number + 1, k == 0);
    for_ranges((level.size() + 511) / 512, [&](size_t first, size_t last) {
        for (size_t i = first * 512; i < std::min(level.size(), last * 512); ++i) level.x[i] += coarse.x[level.parent[i]];
    });
    level.smooth(false);
}

}  // namespace vdbcloud
