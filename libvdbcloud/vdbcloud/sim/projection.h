#pragma once
// The pressure that keeps the air incompressible, found directly: transforms in x and y, elimination in z. Private to
// sim/.
#include "vdbcloud/fft/batched_transform.h"
#include "vdbcloud/sim/field.h"

#include <memory>
#include <vector>

namespace vdbcloud::sim {

/// Density of the base state relative to its value at the floor: 1 everywhere in the Boussinesq set.
struct BaseDensity {
    std::vector<double> centre;  ///< nz values
    std::vector<double> face;    ///< nz + 1 values, floor and lid included
    static BaseDensity uniform(int nz);
};

/// Scratch for the planes of a transform: one value a cell, without halo, aligned.
template<typename T>
class Planes {
public:
    Planes(size_t plane_length, size_t row_length, int planes);
    T* row(int j, int k) { return data_.get() + plane_ * size_t(k) + row_ * size_t(j); }
    const T* row(int j, int k) const { return data_.get() + plane_ * size_t(k) + row_ * size_t(j); }
    T* plane(int k) { return data_.get() + plane_ * size_t(k); }
    size_t bytes() const { return bytes_; }

private:
    struct Free {
        void operator()(T* p) const { ::operator delete(p, std::align_val_t(64)); }
    };
    size_t plane_, row_, bytes_;
    std::unique_ptr<T, Free> data_;
};

/// Removes the divergence of a velocity on the staggered grid:
///
///     V <- V - grad phi,   div(rho V) = 0,   so   div(rho grad phi) = div(rho V)
///
/// with the discrete operators of the grid, so that the remaining divergence is round-off. In x and y the discrete
/// cosines diagonalise the differences, with eigenvalue -4 sin^2(half phase)/h^2; each mode leaves a tridiagonal system
/// in z, which is eliminated without a subtraction (pivots are sums of positive terms), so single precision keeps its
/// relative accuracy for the longest waves. The mean mode is fixed by phi = 0 at the lid, unless a side is open:
/// there phi = 0 on the faces. Schumann and Sweet 1988 is the classical description.
///
/// Threads: all of TBB's; every value is computed by one fixed sequence of operations.
template<typename T>
class Projection {
public:
    Projection(const Lattice&, const BaseDensity&);

    /// One value a cell that callers may use between calls; project() overwrites it.
    Planes<T>& scratch() { return phi_; }

    /// Solves div(rho grad phi) = d, with d in the scratch on entry and phi on exit.
    void solve();

    /// Needs the faces that are computed, and fills the halos. Fields along flat axes may be empty.
    void project(Field<T>& u, Field<T>& v, Field<T>& w);

    /// max |div(rho V)| / rho [1/s].
    double max_divergence(const Field<T>& u, const Field<T>& v, const Field<T>& w) const;

    size_t bytes() const { return phi_.bytes(); }

private:
    void divergence_row(const Field<T>& u, const Field<T>& v, const Field<T>& w, int j, int k, T* out) const;
    void solve_columns(int j);
    void solve_modes();
    void correct_plane(Field<T>& u, Field<T>& v, Field<T>& w, int k);

    Lattice lattice_;
    BaseDensity rho_;
    fft::BatchedTransform<T> transform_;
    std::vector<T> lambda_x_, lambda_y_;  // eigenvalues of minus the second difference [1/m^2]
    Planes<T> phi_;
};

extern template class Planes<float>;
extern template class Planes<double>;
extern template class Projection<float>;
extern template class Projection<double>;

}  // namespace vdbcloud::sim
