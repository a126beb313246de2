#include "vdbcloud/solve/stencil.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/parallel.h"

namespace vdbcloud {

namespace kernels {

static_assert(sizeof(std::array<int32_t, 6>) == sizeof(int32_t[6]));

StencilArrays arrays_of(const Stencil& a)
{
    const Blocks& blocks = *a.blocks;
    return {a.face[0].data(), a.face[1].data(), a.face[2].data(), a.extra.data(),
            blocks.count() ? reinterpret_cast<const int32_t(*)[6]>(&blocks.neighbours(0)) : nullptr};
}

namespace {

VDBCLOUD_CLONES double apply_block(const StencilArrays& a, size_t block, const double* x, double* y)
{
    Doubles lanes{};
    over_rows<double>(
        a, block,
        Values<double>{x}, [&](size_t slot, Doubles v, Doubles product, Floats) __attribute__((always_inline)) {
            store(y + slot, product);
            lanes += v * product;
        });
    return sum(lanes);
}

VDBCLOUD_CLONES double dot_block(const double* a, const double* b)
{
    Doubles lanes{};
    for (int row = 0; row < 512; row += 8) lanes += load(a + row) * load(b + row);
    return sum(lanes);
}

}  // namespace
}  // namespace kernels

Stencil::Stencil(const Blocks& of)
    : blocks(&of), links(std::make_shared<std::array<std::vector<float>, 3>>()), face(*links), extra(of.slots(), 0.0f)
{
    for (auto& coefficients : face) coefficients.assign(of.slots(), 0.0f);
}

size_t Stencil::bytes() const { return 4 * extra.size() * sizeof(float); }

double apply(const Stencil& a, const std::vector<double>& x, std::vector<double>& y)
{
    const auto arrays = kernels::arrays_of(a);
    return ordered_sum(a.blocks->count(),
                       [&](size_t block) { return kernels::apply_block(arrays, block, x.data(), y.data()); });
}

double dot(const Blocks& blocks, const double* a, const double* b)
{
    return ordered_sum(blocks.count(), [&](size_t k) { return kernels::dot_block(a + k * 512, b + k * 512); });
}

namespace {
template<typename T>
double sum_of(const Blocks& blocks, const T* a)
{
    return ordered_sum(blocks.count(), [&](size_t k) {
        double total = 0;
        for (int i = 0; i < Blocks::size; ++i) total += double(a[k * 512 + i]);
        return total;
    });
}
}  // namespace

double sum(const Blocks& blocks, const double* a) { return sum_of(blocks, a); }
double sum(const Blocks& blocks, const float* a) { return sum_of(blocks, a); }

}  // namespace vdbcloud
