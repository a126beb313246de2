#pragma once
// The pressure that lets no air through bodies. Private to sim/.
#include "vdbcloud/sim/openness.h"
#include "vdbcloud/sim/projection.h"

namespace vdbcloud::sim {

/// Removes the divergence of the fluxes through open faces: with the share a of a face,
///
///     V <- V - grad phi,   div(rho a V) = 0,   so   div(rho a grad phi) = div(rho a V)
///
/// and V = 0 on faces that are closed: the weights of Batty, Bertails and Bridson 2007 by the areas of Ng, Min and
/// Gibou 2009. Conjugate gradients, preconditioned by the direct solve of the empty box, which is spectrally equivalent
/// whatever the spacing, between Jacobi sweeps, which settle cells that bodies cut to slivers and narrow valleys.
///
/// Threads: all of TBB's; every value is computed by one fixed sequence of operations.
template<typename T>
class ObstacleSolve {
public:
    /// The projection of the empty box and the geometry outlive this.
    ObstacleSolve(const Lattice&, const BaseDensity&, Projection<T>&, Openness<T>&);

    /// Needs the faces that are computed, fills the halos, and sets the fluxes. `scale`: a velocity [m/s] that errors
    /// are relative to.
    void project(Field<T>& u, Field<T>& v, Field<T>& w, double scale);
    /// The fluxes of a velocity that is already free of divergence.
    void set_flux(const Field<T>& u, const Field<T>& v, const Field<T>& w);
    uint64_t iterations() const { return iterations_; }
    size_t bytes() const;

private:
    struct Ghosts;
    void close(Field<T>& u, Field<T>& v, Field<T>& w) const;
    double residual(Field<T>& out) const;
    void apply(Field<T>& p, Field<T>& out) const;
    void precondition();
    template<typename F>
    void for_rows(const F&) const;
    void fill_ghosts(Field<T>& p) const;
    double dot(const Field<T>& a, const Field<T>& b) const;
    bool solve(double tolerance);
    void correct(Field<T>& u, Field<T>& v, Field<T>& w);

    Lattice lattice_;
    BaseDensity rho_;
    Projection<T>& box_;
    Openness<T>& open_;
    Field<T> x_, r_, p_, q_, z_;  // solution, residual, direction, its image, preconditioned residual
    Field<T> damped_;             // damping / diagonal, 0 within bodies
    uint64_t iterations_ = 0;
};

extern template class ObstacleSolve<float>;
extern template class ObstacleSolve<double>;

}  // namespace vdbcloud::sim
