#pragma once
// Two-dimensional real transforms of many planes, one plane a call: what separates a constant-coefficient operator in x
// and y. Each axis has its own boundary.
#include <cstddef>
#include <memory>

namespace vdbcloud::fft {

/// What lies beyond the ends of an axis of n cell centres, and so which transform diagonalises
/// (D f)_i = f_(i-1) - 2 f_i + f_(i+1) along it. Every eigenvalue is -4 sin^2(half_phase).
enum class AxisEnd {
    Periodic,  ///< f_n = f_0: Fourier, half phases pi m / n
    Even,      ///< mirrored at the outer faces (no gradient): DCT-II, pi m / (2n)
    Odd,       ///< mirrored with the sign changed (zero at the outer faces): DST-II, pi (m + 1) / (2n)
};

/// Transforms planes f(i, j), 0 <= i < nx fastest, in place. A plane is ny rows of row_length() reals, of which the
/// first nx hold the field; after forward() the first modes_x() of each row hold coefficients, and any function of
/// half_phase_x(i), half_phase_y(j) may multiply them. backward(forward(f)) = f / scale().
///
/// Where both axes are periodic a row holds nx/2 + 1 complex numbers, re and im in turn; otherwise nx real
/// coefficients. Planes must start at multiples of `alignment` bytes (fft/planner.h); plane_length() keeps that for
/// stacked planes. Threads: an instance may be shared; every call transforms its own plane with the same plan, so
/// values do not depend on who calls. Planned by estimate, so they do not depend on the run either.
template<typename Real>
class BatchedTransform {
public:
    /// Throws InputError unless nx and ny are in 1..16384.
    BatchedTransform(int nx, int ny, AxisEnd x, AxisEnd y);
    ~BatchedTransform();
    BatchedTransform(BatchedTransform&&) noexcept;

    size_t row_length() const { return row_; }      ///< reals from one row to the next
    size_t plane_length() const { return plane_; }  ///< reals from one plane to the next
    int modes_x() const { return modes_x_; }        ///< reals of a row in use after forward()
    int modes_y() const { return ny_; }
    double scale() const { return scale_; }  ///< 1 / (product of both transforms' lengths)

    double half_phase_x(int i) const;
    double half_phase_y(int j) const;

    void forward(Real* plane) const;
    void backward(Real* plane) const;

private:
    struct Impl;
    int nx_, ny_, modes_x_;
    AxisEnd x_, y_;
    size_t row_, plane_;
    double scale_;
    std::unique_ptr<Impl> impl_;
};

extern template class BatchedTransform<float>;
extern template class BatchedTransform<double>;

}  // namespace vdbcloud::fft
