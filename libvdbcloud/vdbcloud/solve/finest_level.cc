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

/// The first smoothing step from a zero guess, for over_rows().
struct FirstStep {
    const float* inverse;
    const double* b;
    VDBCLOUD_INLINE Floats row(size_t slot) const { return all(first_step) * load(inverse + slot) * floats(b + slot); }
    VDBCLOUD_INLINE float one(size_t slot) const { return first_step * inverse[slot] * float(b[slot]); }
};

/// Both smoothing steps from a zero guess, in one pass.
VDBCLOUD_CLONES void smooth_from_zero(const StencilArrays& a, const float* inverse, const double* b, float* x,
                                      size_t block)
{
    over_rows<float>(
        a, block, FirstStep{inverse, b}, [=](size_t row, Floats v, Floats product) __attribute__((always_inline)) {
            store(x + row, all(1 + keep) * v + all(second_step) * load(inverse + row) * (floats(b + row) - product));
        });
}

/// The first step from x to y.
VDBCLOUD_CLONES void smooth_first(const StencilArrays& a, const float* inverse, const double* b, const float* x,
                                  float* y, size_t block)
{
    over_rows<float>(
        a, block, Values<float>{x}, [=](size_t row, Floats v, Floats product) __attribute__((always_inline)) {
            store(y + row, v + all(first_step) * load(inverse + row) * (floats(b + row) - product));
        });
}

/// The second step: x1 is the result of the first step, x its start and then the end. Returns x . b.
VDBCLOUD_CLONES double smooth_second(const StencilArrays& a, const float* inverse, const double* b, const float* x1,
                                     float* x, size_t block)
{
    Doubles xb{};
    over_rows<float>(
        a, block, Values<float>{x1}, [&](size_t row, Floats v, Floats product) __attribute__((always_inline)) {
            const Floats step = load(inverse + row) * (floats(b + row) - product);
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
        a, block, Values<float>{x}, [&](size_t row, Floats, Floats product) __attribute__((always_inline)) {
            store(residual + row % 512, floats(b + row) - product);
        });
    for (int g = 0; g < groups; ++g) sums[g] = 0;
    for (int i = 0; i < 512; ++i)
        if (group[i] != VoxelGroups::none) sums[group[i]] += residual[i];
}

/// 1 / diagonal of a block, 0 where there is none.
VDBCLOUD_CLONES void inverse_diagonal(const StencilArrays& a, size_t block, float* inverse)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const RowLinks c = row_links(a, block, x, y);
            const size_t row = block * 512 + size_t(x * 64 + y * 8);
            const Floats diagonal = load(a.extra + row) + (((c.xm + c.xp) + (c.ym + c.yp)) + (c.zm + c.zp));
            store(inverse + row, diagonal > 0 ? all(1.0f) / diagonal : Floats{});
        }
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
    : a_(a), groups_(group_voxels(a)), inverse_(a.blocks->slots(), 0.0f), x_(a.blocks->slots(), 0.0f),
      other_(a.blocks->slots(), 0.0f)
{
    const StencilArrays arrays = arrays_of(a_);
    each_block(*a_.blocks, [&](size_t block) { inverse_diagonal(arrays, block, inverse_.data()); });
}

size_t FinestLevel::bytes() const { return 4 * 3 * x_.size() + groups_.bytes(); }

void FinestLevel::descend(const std::vector<double>& residual, std::vector<float>& coarse_b)
{
    const StencilArrays a = arrays_of(a_);
    each_block(*a_.blocks,
               [&](size_t block) { smooth_from_zero(a, inverse_.data(), residual.data(), x_.data(), block); });
    each_block(*a_.blocks, [&](size_t block) {
        const int first = groups_.first[block], rows = groups_.first[block + 1] - first;
        restrict_residual(a, residual.data(), x_.data(), groups_.of.data() + block * 512, coarse_b.data() + first, rows,
                          block);
    });
}

double FinestLevel::ascend(const std::vector<double>& residual, const std::vector<float>& coarse_x)
{
    const StencilArrays a = arrays_of(a_);
    each_block(*a_.blocks, [&](size_t block) {
        const float* from = coarse_x.data() + groups_.first[block];
        for (size_t slot = block * 512; slot < block * 512 + 512; ++slot)
            if (groups_.of[slot] != VoxelGroups::none) x_[slot] += from[groups_.of[slot]];
    });
    each_block(*a_.blocks, [&](size_t block) {
        smooth_first(a, inverse_.data(), residual.data(), x_.data(), other_.data(), block);
    });
    return ordered_sum(a_.blocks->count(), [&](size_t block) {
        return smooth_second(a, inverse_.data(), residual.data(), other_.data(), x_.data(), block);
    });
}

}  // namespace vdbcloud
