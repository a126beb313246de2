#pragma once
// Real fields in three dimensions and their discrete Fourier transform, in place, in float or double.
#include "vdbcloud/core/fwd.h"

#include <complex>
#include <cstddef>
#include <functional>
#include <memory>

namespace vdbcloud::fft {

/// Storage that is first a real field f(i, j, k), 0 <= i < nx and so on, k fastest, and after a transform its
/// half spectrum F(a, b, c), 0 <= a < nx, 0 <= b < ny, 0 <= c <= nz/2. Rows are padded to a common, aligned
/// length, a multiple of 16 floats; what pads a row is 0 after a backward transform. What a new one holds is
/// undefined. Bytes: nx ny row_length() sizeof(Real), 3 % over the field itself at 512^3.
template<typename Real>
class RealField {
public:
    /// Throws InputError unless every size is in 1..4096.
    explicit RealField(const Vec3i& size);

    const Vec3i& size() const { return size_; }
    size_t row_length() const { return row_; }  ///< reals from one row (i, j) to the next
    size_t modes_per_row() const { return size_t(size_[2]) / 2 + 1; }

    Real* row(int i, int j) { return data_.get() + (size_t(i) * size_t(size_[1]) + size_t(j)) * row_; }
    const Real* row(int i, int j) const { return data_.get() + (size_t(i) * size_t(size_[1]) + size_t(j)) * row_; }
    Real& operator()(int i, int j, int k) { return row(i, j)[k]; }
    Real operator()(int i, int j, int k) const { return row(i, j)[k]; }

    std::complex<Real>* modes(int a, int b) { return reinterpret_cast<std::complex<Real>*>(row(a, b)); }
    const std::complex<Real>* modes(int a, int b) const
    {
        return reinterpret_cast<const std::complex<Real>*>(row(a, b));
    }

    /// Bytes that a field of this size takes.
    static size_t bytes(const Vec3i& size);

private:
    struct Free {
        void operator()(Real*) const;
    };
    Vec3i size_;
    size_t row_;
    std::unique_ptr<Real[], Free> data_;
};

/// The transform of fields of one size, of any factors (primes cost about five times as much):
///
///     forward:   F(a, b, c) = sum_ijk f(i, j, k) exp(-2 pi I (a i / nx + b j / ny + c k / nz))
///     backward:  f(i, j, k) = sum_abc F(a, b, c) exp(+2 pi I (...))  over the full, Hermitian spectrum
///
/// Neither scales, so forward then backward multiplies by nx ny nz. Only the half c <= nz/2 is stored; in its
/// planes c = 0 and c = nz/2 (nz even) backward expects F(-a, -b, c) = conj F(a, b, c) and quietly takes the
/// Hermitian part.
///
/// Threads: all of TBB's, over planes and then over blocks of columns. Each part is transformed whole by one
/// thread with the same plan, so values do not depend on how many there are. An instance may be shared by
/// threads.
template<typename Real>
class RealTransform {
public:
    explicit RealTransform(const Vec3i& size);
    ~RealTransform();
    RealTransform(RealTransform&&) noexcept;
    RealTransform& operator=(RealTransform&&) noexcept;

    /// In place. Throws InputError if the field has another size.
    void forward(RealField<Real>&) const;
    void backward(RealField<Real>&) const;

    /// Writes F(a, b, c0 + w) to out[a * stride + w] for one b, `width` values of c from c0 on, and every a.
    /// Returns false if all of them are 0; `out` is then ignored. Called from several threads
    /// at once.
    using Modes = std::function<bool(int b, int c0, int width, std::complex<Real>* out, int stride)>;

    /// backward() of a spectrum that is made as it is needed: what the field held is replaced. A third of the
    /// memory traffic of filling the field first, and columns that are all 0 are not transformed.
    void backward(const Modes&, RealField<Real>&) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

extern template class RealField<float>;
extern template class RealField<double>;
extern template class RealTransform<float>;
extern template class RealTransform<double>;

}  // namespace vdbcloud::fft
