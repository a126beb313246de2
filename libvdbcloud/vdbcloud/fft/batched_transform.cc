#include "vdbcloud/fft/batched_transform.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/fft/fftw_names.h"
#include "vdbcloud/fft/planner.h"

#include <new>
#include <string>

namespace vdbcloud::fft {

namespace {

fftw_r2r_kind kind(AxisEnd end, bool forward)
{
    switch (end) {
    case AxisEnd::Periodic: return forward ? FFTW_R2HC : FFTW_HC2R;
    case AxisEnd::Even: return forward ? FFTW_REDFT10 : FFTW_REDFT01;
    default: return forward ? FFTW_RODFT10 : FFTW_RODFT01;
    }
}

double length(AxisEnd end, int n) { return end == AxisEnd::Periodic ? n : 2.0 * n; }

double half_phase(AxisEnd end, int m, int n)
{
    switch (end) {
    case AxisEnd::Periodic: return pi * m / n;
    case AxisEnd::Even: return pi * m / (2.0 * n);
    default: return pi * (m + 1) / (2.0 * n);
    }
}

/// Plans and runs in place.
template<typename Real>
struct Fftw {
    using Names = FftwNames<Real>;
    using Complex = typename Names::Complex;

    static auto r2c(const fftw_iodim* d, Real* a)
    {
        const fftw_iodim out[2] = {{d[0].n, d[0].is, d[0].is / 2}, d[1]};
        return Names::plan_guru_r2c(2, out, 0, nullptr, a, reinterpret_cast<Complex*>(a), FFTW_ESTIMATE);
    }
    static auto c2r(const fftw_iodim* d, Real* a)
    {
        const fftw_iodim out[2] = {{d[0].n, d[0].is / 2, d[0].is}, d[1]};
        return Names::plan_guru_c2r(2, out, 0, nullptr, reinterpret_cast<Complex*>(a), a, FFTW_ESTIMATE);
    }
    static auto r2r(const fftw_iodim* d, Real* a, const fftw_r2r_kind* k)
    {
        return Names::plan_guru_r2r(2, d, 0, nullptr, a, a, k, FFTW_ESTIMATE);
    }
    template<typename P>
    static void run_r2c(P p, Real* a)
    {
        Names::run_r2c(p, a, reinterpret_cast<Complex*>(a));
    }
    template<typename P>
    static void run_c2r(P p, Real* a)
    {
        Names::run_c2r(p, reinterpret_cast<Complex*>(a), a);
    }
    template<typename P>
    static void run_r2r(P p, Real* a)
    {
        Names::run_r2r(p, a, a);
    }
};

}  // namespace

template<typename Real>
struct BatchedTransform<Real>::Impl {
    Plan<Real> forward, backward;
    bool complex;
};

template<typename Real>
BatchedTransform<Real>::BatchedTransform(int nx, int ny, AxisEnd x, AxisEnd y)
    : nx_(nx), ny_(ny), modes_x_(nx), x_(x), y_(y), row_(0), plane_(0), scale_(0), impl_(std::make_unique<Impl>())
{
    if (nx < 1 || ny < 1 || nx > 16384 || ny > 16384)
        throw InputError("transform of " + std::to_string(nx) + " x " + std::to_string(ny) + ": expected 1..16384");
    impl_->complex = x == AxisEnd::Periodic && y == AxisEnd::Periodic;
    if (impl_->complex) modes_x_ = 2 * (nx / 2 + 1);
    row_ = size_t(modes_x_);
    const size_t unit = alignment / sizeof(Real);
    plane_ = (row_ * size_t(ny) + unit - 1) / unit * unit;
    scale_ = 1.0 / (length(x, nx) * length(y, ny));

    // FFTW_ESTIMATE neither reads nor writes the array, but looks at its alignment.
    std::unique_ptr<Real, void (*)(Real*)> probe(
        static_cast<Real*>(::operator new(plane_ * sizeof(Real), std::align_val_t(alignment))),
        [](Real* p) { ::operator delete(p, std::align_val_t(alignment)); });
    const fftw_iodim sizes[2] = {{ny, int(row_), int(row_)}, {nx, 1, 1}};
    using F = Fftw<Real>;
    if (impl_->complex) {
        impl_->forward = make_plan<Real>([&] { return F::r2c(sizes, probe.get()); });
        impl_->backward = make_plan<Real>([&] { return F::c2r(sizes, probe.get()); });
        return;
    }
    for (const bool ahead : {true, false}) {
        const fftw_r2r_kind kinds[2] = {kind(y, ahead), kind(x, ahead)};
        (ahead ? impl_->forward : impl_->backward) = make_plan<Real>([&] { return F::r2r(sizes, probe.get(), kinds); });
    }
}

template<typename Real>
BatchedTransform<Real>::~BatchedTransform() = default;
template<typename Real>
BatchedTransform<Real>::BatchedTransform(BatchedTransform&&) noexcept = default;

template<typename Real>
double BatchedTransform<Real>::half_phase_x(int i) const
{
    return half_phase(x_, impl_->complex ? i / 2 : i, nx_);
}

template<typename Real>
double BatchedTransform<Real>::half_phase_y(int j) const
{
    return half_phase(y_, j, ny_);
}

template<typename Real>
void BatchedTransform<Real>::forward(Real* plane) const
{
    impl_->complex ? Fftw<Real>::run_r2c(impl_->forward.get(), plane)
                   : Fftw<Real>::run_r2r(impl_->forward.get(), plane);
}

template<typename Real>
void BatchedTransform<Real>::backward(Real* plane) const
{
    impl_->complex ? Fftw<Real>::run_c2r(impl_->backward.get(), plane)
                   : Fftw<Real>::run_r2r(impl_->backward.get(), plane);
}

template class BatchedTransform<float>;
template class BatchedTransform<double>;

}  // namespace vdbcloud::fft
