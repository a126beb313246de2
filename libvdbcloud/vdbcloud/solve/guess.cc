#include "vdbcloud/solve/guess.h"

#include "vdbcloud/solve/block_kernels.h"
#include "vdbcloud/solve/dense.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

using namespace kernels;

namespace {

constexpr double dependent = 1e-6;  // squared sine below which a field adds nothing to those before it

template<typename T>
VDBCLOUD_INLINE void find_image(const StencilArrays& a, size_t block, const T* v, double* image)
{
    over_rows<double>(
        a, block, Values<T>{v},
        [=](size_t slot, const Doubles&, const Doubles& product, const Floats&)
            __attribute__((always_inline)) { store(image + slot % 512, product); });
}

/// A v of one block.
VDBCLOUD_CLONES void image_of(const StencilArrays& a, size_t block, const float* v, double* image)
{
    find_image(a, block, v, image);
}

VDBCLOUD_CLONES void image_of_double(const StencilArrays& a, size_t block, const double* v, double* image)
{
    find_image(a, block, v, image);
}

VDBCLOUD_CLONES double product_with(const float* v, const double* other)
{
    Doubles lanes{};
    for (int row = 0; row < 512; row += 8) lanes += as<double>(load(v + row)) * load(other + row);
    return sum(lanes);
}

VDBCLOUD_CLONES double product_with_double(const double* v, const double* other)
{
    Doubles lanes{};
    for (int row = 0; row < 512; row += 8) lanes += load(v + row) * load(other + row);
    return sum(lanes);
}

VDBCLOUD_CLONES void add_times(double factor, const float* v, double* x)
{
    for (int row = 0; row < 512; row += 8) store(x + row, load(x + row) + all(factor) * as<double>(load(v + row)));
}

/// x, where it is not empty, and the fields.
struct Basis {
    const Stencil& a;
    const std::vector<const std::vector<float>*>& fields;
    const std::vector<double>& x;

    bool has_x() const { return !x.empty(); }
    size_t size() const { return fields.size() + has_x(); }
    const float* field(size_t i) const { return fields[i - has_x()]->data(); }

    double with(size_t i, size_t block, const double* other) const
    {
        if (has_x() && i == 0) return product_with_double(x.data() + block * 512, other);
        return product_with(field(i) + block * 512, other);
    }
    void image(const StencilArrays& arrays, size_t i, size_t block, double* to) const
    {
        if (has_x() && i == 0) return image_of_double(arrays, block, x.data(), to);
        image_of(arrays, block, field(i), to);
    }
};

/// The products of the basis with its images, n x n, and with b.
struct Products {
    std::vector<double> energy, right;
};
Products products_of(const Basis& basis, const std::vector<double>& b)
{
    const size_t n = basis.size(), each = n * n + n, count = basis.a.blocks->count();
    const StencilArrays arrays = arrays_of(basis.a);
    std::vector<double> terms(each * count, 0.0);
    for_ranges(count, [&](size_t first, size_t last) {
        alignas(64) double image[Blocks::size];
        for (size_t block = first; block < last; ++block)
            for (size_t i = 0; i < n; ++i) {
                double* own = terms.data() + each * block;
                basis.image(arrays, i, block, image);
                for (size_t j = 0; j <= i; ++j) own[i * n + j] = basis.with(j, block, image);
                own[n * n + i] = basis.with(i, block, b.data() + block * Blocks::size);
            }
    });
    std::vector<double> sums(each, 0.0);
    for (size_t k = 0; k < terms.size(); ++k) sums[k % each] += terms[k];
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < i; ++j) sums[j * n + i] = sums[i * n + j];
    return {{sums.begin(), sums.end() - ptrdiff_t(n)}, {sums.end() - ptrdiff_t(n), sums.end()}};
}

}  // namespace

void improve_guess(const Stencil& a, const std::vector<double>& b, const std::vector<const std::vector<float>*>& fields,
                   std::vector<double>& x)
{
    const Basis basis{a, fields, x};
    const size_t n = basis.size();
    const auto [energy, right] = products_of(basis, b);
    if (!std::all_of(energy.begin(), energy.end(), [](double e) { return std::isfinite(e); })) return;
    std::vector<double> factor = SemidefiniteFactor(energy, n, dependent).solve(right);
    double of_x = 0;
    if (basis.has_x()) {
        of_x = factor[0];
        factor.erase(factor.begin());
    } else {
        x.assign(b.size(), 0.0);
    }
    for_ranges(a.blocks->count(), [&](size_t first, size_t last) {
        for (size_t block = first; block < last; ++block) {
            double* to = x.data() + block * Blocks::size;
            for (size_t k = 0; k < Blocks::size; ++k) to[k] *= of_x;
            for (size_t i = 0; i < fields.size(); ++i)
                add_times(factor[i], fields[i]->data() + block * Blocks::size, to);
        }
    });
}

}  // namespace vdbcloud
