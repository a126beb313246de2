#include "vdbcloud/fft/real_transform.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/fft/fftw_names.h"
#include "vdbcloud/fft/planner.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

namespace vdbcloud::fft {

namespace {

template<typename Real>
constexpr size_t per_line = alignment / sizeof(Real);

size_t round_up(size_t n, size_t to) { return (n + to - 1) / to * to; }

template<typename Real>
size_t padded_row(const Vec3i& size)
{
    return round_up(2 * (size_t(size[2]) / 2 + 1), per_line<Real>);
}

template<typename Real>
Real* allocate(size_t n)
{
    constexpr size_t huge = size_t(2) << 20;  // large fields lie on large pages: far fewer page faults
    const size_t bytes = n * sizeof(Real), to = bytes < 4 * huge ? alignment : huge;
    void* p = std::aligned_alloc(to, round_up(bytes, to));
    if (!p) throw std::bad_alloc();
    if (to == huge) madvise(p, round_up(bytes, to), MADV_HUGEPAGE);  // a hint: it may be refused
    return static_cast<Real*>(p);
}

const Vec3i& checked(const Vec3i& size)
{
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < 1 || size[axis] > 4096)
            throw InputError("transform of size " + std::to_string(size[0]) + "," + std::to_string(size[1]) + "," +
                             std::to_string(size[2]) + ": expected 1..4096 along each axis");
    return size;
}

}  // namespace

template<typename Real>
RealField<Real>::RealField(const Vec3i& size)
    : size_(checked(size)), row_(padded_row<Real>(size)),
      data_(allocate<Real>(size_t(size[0]) * size_t(size[1]) * row_))
{
}

template<typename Real>
size_t RealField<Real>::bytes(const Vec3i& size)
{
    return size_t(size[0]) * size_t(size[1]) * padded_row<Real>(size) * sizeof(Real);
}

template<typename Real>
void RealField<Real>::Free::operator()(Real* p) const
{
    std::free(p);
}

/// Two passes: planes (j, k) of fixed i, which are contiguous; then columns along i, several neighbours at a
/// time, copied into a scratch block that stays in the first-level cache, as a column alone would waste most
/// of each cache line.
template<typename Real>
struct RealTransform<Real>::Impl {
    using F = FftwNames<Real>;
    using C = typename F::Complex;
    static constexpr int block = int(per_line<Real>);  // columns at a time: two cache lines of complex numbers

    explicit Impl(const Vec3i& n) : size(n)
    {
        RealField<Real> plane({1, n[1], n[2]});  // plans only look at alignment and layout
        const int dims[2] = {n[1], n[2]};
        const int reals[2] = {n[1], int(plane.row_length())}, modes[2] = {n[1], int(plane.row_length() / 2)};
        auto* r = plane.row(0, 0);
        auto* c = reinterpret_cast<C*>(r);
        planes[0] = make_plan<Real>(
            [&] { return F::plan_many_r2c(2, dims, 1, r, reals, 1, 0, c, modes, 1, 0, FFTW_ESTIMATE); });
        planes[1] = make_plan<Real>(
            [&] { return F::plan_many_c2r(2, dims, 1, c, modes, 1, 0, r, reals, 1, 0, FFTW_ESTIMATE); });

        const auto scratch = this->scratch();
        auto* s = reinterpret_cast<C*>(scratch.get());
        const int width[2] = {block, int(plane.modes_per_row() % block)};
        for (int w = 0; w < 2; ++w)
            for (int d = 0; d < 2 && width[w] > 0; ++d)
                columns[w][d] = make_plan<Real>([&] {
                    return F::plan_many_c2c(1, &size[0], width[w], s, nullptr, block, 1, s, nullptr, block, 1,
                                            d == 0 ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
                });
    }

    /// Copies of a known length need no call, and most are of a whole block.
    static void copy(const std::complex<Real>* from, int width, std::complex<Real>* to)
    {
        if (width == block)
            std::memcpy(static_cast<void*>(to), from, block * sizeof *to);
        else
            std::copy_n(from, width, to);
    }

    static void release(Real* p) { std::free(p); }
    std::unique_ptr<Real[], void (*)(Real*)> scratch() const
    {
        return {allocate<Real>(size_t(size[0]) * block * 2), release};
    }

    void run_planes(RealField<Real>& field, bool forward) const
    {
        tbb::parallel_for(tbb::blocked_range<int>(0, size[0]), [&](const auto& range) {
            for (int i = range.begin(); i != range.end(); ++i) {
                auto* r = field.row(i, 0);
                auto* c = reinterpret_cast<C*>(r);
                forward ? F::run_r2c(planes[0].get(), r, c) : F::run_c2r(planes[1].get(), c, r);
                if (!forward)
                    for (int j = 0; j < size[1]; ++j)
                        std::fill(field.row(i, j) + size[2], field.row(i, j) + field.row_length(), Real(0));
            }
        });
    }

    /// Calls body(j, k, width, scratch) for every block of columns; it is the body that fills and empties the
    /// scratch.
    template<typename Body>
    void over_columns(const Body& body) const
    {
        const int modes = size[2] / 2 + 1;
        tbb::parallel_for(tbb::blocked_range<int>(0, size[1]), [&](const auto& range) {
            const auto memory = scratch();
            auto* s = reinterpret_cast<std::complex<Real>*>(memory.get());
            for (int j = range.begin(); j != range.end(); ++j)
                for (int k = 0; k < modes; k += block) body(j, k, std::min(block, modes - k), s);
        });
    }

    void transform_columns(int width, bool forward, std::complex<Real>* s) const
    {
        auto* c = reinterpret_cast<C*>(s);
        F::run_c2c(columns[width < block][!forward].get(), c, c);
    }

    void run_columns(RealField<Real>& field, bool forward) const
    {
        if (size[0] == 1) return;
        over_columns([&](int j, int k, int width, std::complex<Real>* s) {
            for (int i = 0; i < size[0]; ++i) copy(field.modes(i, j) + k, width, s + size_t(i) * block);
            transform_columns(width, forward, s);
            for (int i = 0; i < size[0]; ++i) copy(s + size_t(i) * block, width, field.modes(i, j) + k);
        });
    }

    void make_columns(const Modes& modes, RealField<Real>& field) const
    {
        over_columns([&](int j, int k, int width, std::complex<Real>* s) {
            if (modes(j, k, width, s, block)) {
                transform_columns(width, false, s);
                for (int i = 0; i < size[0]; ++i) copy(s + size_t(i) * block, width, field.modes(i, j) + k);
            } else {
                for (int i = 0; i < size[0]; ++i) std::fill_n(field.modes(i, j) + k, width, std::complex<Real>());
            }
        });
    }

    void check(const RealField<Real>& field) const
    {
        if (field.size() != size) throw InputError("transform given a field of another size than its own");
    }

    Vec3i size;
    std::array<Plan<Real>, 2> planes;                  // forward, backward
    std::array<std::array<Plan<Real>, 2>, 2> columns;  // [full block, the last of a row][forward, backward]
};

template<typename Real>
RealTransform<Real>::RealTransform(const Vec3i& size) : impl_(new Impl(checked(size)))
{
}
template<typename Real>
RealTransform<Real>::~RealTransform() = default;
template<typename Real>
RealTransform<Real>::RealTransform(RealTransform&&) noexcept = default;
template<typename Real>
RealTransform<Real>& RealTransform<Real>::operator=(RealTransform&&) noexcept = default;

template<typename Real>
void RealTransform<Real>::forward(RealField<Real>& field) const
{
    impl_->check(field);
    impl_->run_planes(field, true);
    impl_->run_columns(field, true);
}

template<typename Real>
void RealTransform<Real>::backward(RealField<Real>& field) const
{
    impl_->check(field);
    impl_->run_columns(field, false);
    impl_->run_planes(field, false);
}

template<typename Real>
void RealTransform<Real>::backward(const Modes& modes, RealField<Real>& field) const
{
    impl_->check(field);
    impl_->make_columns(modes, field);
    impl_->run_planes(field, false);
}

template class RealField<float>;
template class RealField<double>;
template class RealTransform<float>;
template class RealTransform<double>;

}  // namespace vdbcloud::fft
