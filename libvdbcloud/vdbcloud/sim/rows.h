#pragma once
// The arithmetic of the model, one row of cells at a time: each function is a loop over contiguous values that the
// compiler vectorises. No function allocates; neighbours are reached through strides.
#include "vdbcloud/core/clones.h"

#include <cstddef>

namespace vdbcloud::sim {

/// How the value of a scalar on a face is reconstructed from cells.
enum class ScalarScheme {
    Upwind,    ///< the donor's value: first order, as in forward-differenced codes
    Koren,     ///< third order, limited
    Limited5,  ///< fifth order upwind, limited
    Plain5,    ///< fifth order upwind, not limited: for smooth problems
};
enum class MomentumScheme { Upwind, Upwind5 };

/// Fluxes of momentum through the faces between q[i - s] and q[i]: the velocity there, wa a[i] + wb b[i], times q
/// interpolated. Fifth order: Wicker and Skamarock 2002, eq. 4; the sixth-order value less |velocity| times a
/// difference, so no branch.
template<typename T>
struct MomentumFlux {
    const T *a, *b;
    T wa, wb;
    const T* q;
    ptrdiff_t s;
};
void momentum_flux(MomentumScheme, const MomentumFlux<float>&, float* out, int n);
void momentum_flux(MomentumScheme, const MomentumFlux<double>&, double* out, int n);

/// Fluxes of a scalar through the faces between q[i - s] and q[i], velocity v[i]. Limited schemes keep the face value
/// q_f between donor d and acceptor a, and within d + m (d - b) of what lies behind the donor, b:
///
///     q_f = d + minmod(reconstruction - d, a - d, m (d - b)),   m = min(4, drain / tau - 1) of the donor cell
///
/// where `drain` is the time [s] in which the outflow empties a cell. Then a forward step of length tau gives each
/// cell a convex combination of old values (Harten's condition): no new extrema, no negative water, in any number
/// of dimensions, wherever tau <= drain.
template<typename T>
struct ScalarFlux {
    const T *v, *q, *drain;
    T inv_tau;
    ptrdiff_t s;
};
void scalar_flux(ScalarScheme, const ScalarFlux<float>&, float* out, int n);
void scalar_flux(ScalarScheme, const ScalarFlux<double>&, double* out, int n);

/// Tendency of a row of cells from the fluxes through their faces: minus the divergence. Null rows are skipped.
template<typename T>
struct FluxRows {
    const T *x, *y0, *y1, *z0, *z1;  ///< x has n + 1 values; z0, z1 below and above
    T cx, cy, cz0, cz1;              ///< 1 / spacing; in z with the densities of an anelastic base
};
void flux_tendency(const FluxRows<float>&, float* out, int n);
void flux_tendency(const FluxRows<double>&, double* out, int n);

/// One stage: out = x0 + alpha (x1 - x0) + beta (x - x0 + tau tendency). `out` may be x0 or x1. Written in increments,
/// as weights that do not sum to 1 exactly in single precision would make or destroy water.
template<typename T>
struct StageRows {
    T* out;
    const T *x0, *x1, *x, *tendency;
};
/// Results in (least - r, least) become `least`, where r is tiny or 4 ulps of x0 - least, if that is more; of no effect
/// where tiny is 0.
struct ScalarStage {
    double alpha, beta, tau, least, tiny;
};
void scalar_stage(const StageRows<float>&, const ScalarStage&, int n);
void scalar_stage(const StageRows<double>&, const ScalarStage&, int n);

/// The same with an integrating factor: out = a0 x0 + a1 x1 + ax x + al tendency + constant.
struct MomentumStage {
    double a0, a1, ax, al, constant;
};
void momentum_stage(const StageRows<float>&, const MomentumStage&, int n);
void momentum_stage(const StageRows<double>&, const MomentumStage&, int n);

/// How fast the air leaves cells: drain[i] = 1 / outflow rate [s], where the outflow is half the sum of |fluxes|.
/// Returns in `rate` the largest Courant rate, sum over axes of the larger |velocity| / spacing [1/s]; NaN if any
/// velocity is not finite.
template<typename T>
struct CourantRows {
    const T *u, *v0, *v1, *w0, *w1;  ///< u has n + 1 values; null along flat axes
    T cx, cy, cz0, cz1;
};
void courant(const CourantRows<float>&, float* drain, double& rate, int n);
void courant(const CourantRows<double>&, double* drain, double& rate, int n);

/// out[i] += c (a[i] + b[i])
void add_sum(float* out, const float* a, const float* b, float c, int n);
void add_sum(double* out, const double* a, const double* b, double c, int n);

/// out[i] += cx (q[i-1] - 2 q[i] + q[i+1]) + the same along y and z: a seven-point Laplacian with coefficients.
template<typename T>
struct LaplaceRow {
    const T* q;
    ptrdiff_t sx, sy, sz;
    T cx, cy, cz;  ///< 0 along flat axes
};
void add_laplacian(const LaplaceRow<float>&, float* out, int n);
void add_laplacian(const LaplaceRow<double>&, double* out, int n);

/// out[i] -= rate (q[i] - target)
void add_relaxation(float* out, const float* q, float target, float rate, int n);
void add_relaxation(double* out, const double* q, double target, double rate, int n);

}  // namespace vdbcloud::sim
