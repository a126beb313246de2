#include "vdbcloud/solve/finest_level.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/chebyshev.h"
#include "vdbcloud/solve/parallel.h"

namespace vdbcloud {

using namespace kernels;
using namespace chebyshev;

namespace {

VDBCLOUD_INLINE Floats floats(const double* from) { return as<float>(load(from)); }

/// 1 / diagonal, 0 where there is none.
VDBCLOUD_INLINE Floats inverse(const Floats& diagonal) { return diagonal > 0 ? all(1.0f) / diagonal : Floats{}; }

/// The first step from a zero guess.
VDBCLOUD_CLONES void smooth_zero(const StencilArrays& a, const double* b, float* x, size_t block)
{
    for (int x_in = 0; x_in < 8; ++x_in)
        for (int y = 0; y < 8; ++y) {
            const size_t row = block * 512 + size_t(x_in * 64 + y * 8);
            const RowLinks c = row_links(a, block, x_in, y);
            const Floats diagonal = load(a.extra + row) + (((c.xm + c.xp) + (c.ym + c.yp)) + (c.zm + c.zp));
            store(x + row, all(first_step) * inverse(diagonal) * floats(b + row));
        }
}

/// The second step after the first step from a zero guess.
VDBCLOUD_CLONES void smooth_second_from_zero(const StencilArrays& a, const double* b, const float* x1, float* x,
                                             size_t block)
{
    over_rows<float>(
        a, block,
        Values<float>{x1}, [=](size_t row, Floats v, Floats product, Floats diagonal) __attribute__((always_inline)) {
            store(x + row, all(1 + keep) * v + all(second_step) * inverse(diagonal) * (floats(b + row) - product));
        });
}

/// The first step from x to y.
VDBCLOUD_CLONES void smooth_first(const StencilArrays& a, const double* b, const float* x, float* y, size_t block)
{
    over_rows<float>(
        a, block,
        Values<float>{x}, [=](size_t row, Floats v, Floats product, Floats diagonal) __attribute__((always_inline)) {
            store(y + row, v + all(first_step) * inverse(diagonal) * (floats(b + row) - product));
        });
}

/// The second step: x1 is the result of the first step, x its start and then the end. Returns x . b.
VDBCLOUD_CLONES double smooth_second(const StencilArrays& a, const double* b, const float* x1, float* x, size_t block)
{
    Doubles xb{};
    over_rows<float>(
        a, block,
        Values<float>{x1}, [&](size_t row, Floats v, Floats product, Floats diagonal) __attribute__((always_inline)) {
            const Floats step = inverse(diagonal) * (floats(b + row) - product);
            const Floats end = v + all(keep) * (v - load(x + row)) + all(second_step) * step;
            store(x + row, end);
            xb += as<double>(end) * load(b + row);
        });
    return sum(xb);
}

/// The residual of one block, summed over groups.
VDBCLOUD_CLONES void restrict_residual(const StencilArrays& a, const double* b, const float* x, const uint16_t* group,
                                       float* sums, int groups, size_t block)
{
    alignas(32) float residual[512];
    over_rows<float>(
        a, block, Values<float>{x}, [&](size_t row, Floats, Floats product, Floats) __attribute__((always_inline)) {
            store(residual + row % 512, floats(b + row) - product);
        });
    for (int g = 0; g < groups; ++g) sums[g] = 0;
    for (int i = 0; i < 512; ++i)
        if (group[i] != VoxelGroups::none) sums[group[i]] += residual[i];
}

template<typename F>
void each_block(const Blocks& blocks, const F& f)
{
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block) f(block);
    });
}

}  // namespace

FinestLevel::FinestLevel(const Stencil& a)
    : a_(a), groups_(std::make_shared<VoxelGroups>(group_voxels(a))), fields_(std::make_shared<Fields>())
{
}

FinestLevel::FinestLevel(const Stencil& a, const FinestLevel& like)
    : a_(a), groups_(like.groups_), fields_(like.fields_), owns_(false)
{
}

void FinestLevel::make_fields()
{
    fields_->x.assign(a_.blocks->slots(), 0.0f);
    fields_->other.assign(a_.blocks->slots(), 0.0f);
}

std::vector<float> FinestLevel::next_extra(const FinestLevel& like, std::vector<float> extra) const
{
    for_ranges(a_.blocks->count(), [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block) {
            double more[Blocks::size] = {};
            for (size_t slot = block * Blocks::size; slot < (block + 1) * Blocks::size; ++slot)
                if (const uint16_t group = groups_->of[slot]; group != VoxelGroups::none)
                    more[group] += double(a_.extra[slot]) - like.a_.extra[slot];
            const int32_t from = groups_->first[block], count = groups_->first[block + 1] - from;
            for (int32_t g = 0; g < count; ++g) extra[size_t(from + g)] = float(extra[size_t(from + g)] + more[g]);
        }
    });
    return extra;
}

size_t FinestLevel::bytes() const { return owns_ ? 8 * fields_->x.size() + groups_->bytes() : 0; }

void FinestLevel::descend(const std::vector<double>& residual, std::vector<float>& coarse_b)
{
    const StencilArrays a = arrays_of(a_);
    float *x = fields_->x.data(), *other = fields_->other.data();
    each_block(*a_.blocks, [&](size_t block) { smooth_zero(a, residual.data(), other, block); });
    each_block(*a_.blocks, [&](size_t block) { smooth_second_from_zero(a, residual.data(), other, x, block); });
    each_block(*a_.blocks, [&](size_t block) {
        const int first = groups_->first[block], rows = groups_->first[block + 1] - first;
        restrict_residual(a, residual.data(), x, groups_->of.data() + block * 512, coarse_b.data() + first, rows,
                          block);
    });
}

double FinestLevel::ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x)
{
    const StencilArrays a = arrays_of(a_);
    float *x = fields_->x.data(), *other = fields_->other.data();
    const uint16_t* of = groups_->of.data();
    each_block(*a_.blocks, [&](size_t block) {
        const float* from = coarse_x.data() + groups_->first[block];
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot)
            if (of[slot] != VoxelGroups::none) x[slot] += from[of[slot]];
    });
    each_block(*a_.blocks, [&](size_t block) { smooth_first(a, residual.data(), x, other, block); });
    return ordered_sum(a_.blocks->count(),
                       [&](size_t block) { return smooth_second(a, residual.data(), other, x, block); });
}

}  // namespace vdbcloud
