#include "vdbcloud/sim/projection.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/sim/parallel.h"

#include <cmath>

namespace vdbcloud::sim {

namespace {

fft::AxisEnd end_of(const Lattice& lattice, int axis)
{
    if (lattice.flat(axis)) return fft::AxisEnd::Periodic;
    switch (lattice.side[size_t(axis)]) {
    case Side::Periodic: return fft::AxisEnd::Periodic;
    case Side::Wall: return fft::AxisEnd::Even;
    default: return fft::AxisEnd::Odd;
    }
}

/// out = (u[i+1] - u[i]) cu + (vn - vs) cv + (w_top ct - w_bottom cb)
template<typename T>
struct DivergenceTerms {
    const T *u, *vs, *vn, *wb, *wt;
    T cu, cv, cb, ct;
};
template<typename T>
VDBCLOUD_INLINE void divergence(const DivergenceTerms<T>& d, T* out, int n)
{
    for (int i = 0; i < n; ++i) out[i] = d.wt[i] * d.ct - d.wb[i] * d.cb;
    if (d.u)
        for (int i = 0; i < n; ++i) out[i] += (d.u[i + 1] - d.u[i]) * d.cu;
    if (d.vs)
        for (int i = 0; i < n; ++i) out[i] += (d.vn[i] - d.vs[i]) * d.cv;
}
VDBCLOUD_WIDE_CLONES void divergence_clones(const DivergenceTerms<float>& d, float* out, int n)
{
    divergence(d, out, n);
}
VDBCLOUD_WIDE_CLONES void divergence_clones(const DivergenceTerms<double>& d, double* out, int n)
{
    divergence(d, out, n);
}

/// One level of the elimination upwards, for a row of modes. With s >= 0 the part of the pivot that is not the coupling
/// `a` to the level above: y <- y - d, m = a / (s + a), and both s and y are multiplied by m for the next level.
template<typename T>
VDBCLOUD_INLINE void eliminate(T* s, T* carry, T* m, T* f, T a, T inv_a, int n)
{
    for (int i = 0; i < n; ++i) {
        const T ratio = a / (s[i] + a);
        const T y = carry[i] - f[i];
        m[i] = ratio;
        f[i] = y * inv_a;
        carry[i] = ratio * y;
        s[i] *= ratio;
    }
}
VDBCLOUD_WIDE_CLONES void eliminate_clones(float* s, float* c, float* m, float* f, float a, float inv_a, int n)
{
    eliminate(s, c, m, f, a, inv_a, n);
}
VDBCLOUD_WIDE_CLONES void eliminate_clones(double* s, double* c, double* m, double* f, double a, double inv_a, int n)
{
    eliminate(s, c, m, f, a, inv_a, n);
}

template<typename T>
VDBCLOUD_INLINE void substitute(const T* m, const T* above, T* f, int n)
{
    for (int i = 0; i < n; ++i) f[i] = m[i] * (f[i] + above[i]);
}
VDBCLOUD_WIDE_CLONES void substitute_clones(const float* m, const float* above, float* f, int n)
{
    substitute(m, above, f, n);
}
VDBCLOUD_WIDE_CLONES void substitute_clones(const double* m, const double* above, double* f, int n)
{
    substitute(m, above, f, n);
}

/// v[i] -= (p[i] - q[i]) c
template<typename T>
VDBCLOUD_INLINE void subtract_difference(T* v, const T* p, const T* q, T c, int n)
{
    for (int i = 0; i < n; ++i) v[i] -= (p[i] - q[i]) * c;
}
VDBCLOUD_WIDE_CLONES void subtract_clones(float* v, const float* p, const float* q, float c, int n)
{
    subtract_difference(v, p, q, c, n);
}
VDBCLOUD_WIDE_CLONES void subtract_clones(double* v, const double* p, const double* q, double c, int n)
{
    subtract_difference(v, p, q, c, n);
}

}  // namespace

BaseDensity BaseDensity::uniform(int nz)
{
    return {std::vector<double>(size_t(nz), 1.0), std::vector<double>(size_t(nz) + 1, 1.0)};
}

template<typename T>
Planes<T>::Planes(size_t plane_length, size_t row_length, int planes)
    : plane_(plane_length), row_(row_length), bytes_(plane_length * size_t(planes) * sizeof(T)),
      data_(static_cast<T*>(::operator new(bytes_, std::align_val_t(64))))
{
    std::fill_n(data_.get(), plane_length * size_t(planes), T(0));
}

template<typename T>
Projection<T>::Projection(const Lattice& lattice, const BaseDensity& rho)
    : lattice_(lattice), rho_(rho), transform_(lattice.n[0], lattice.n[1], end_of(lattice, 0), end_of(lattice, 1)),
      phi_(transform_.plane_length(), transform_.row_length(), lattice.n[2])
{
    const auto eigenvalue = [](double half_phase, double h) { return std::pow(2 * std::sin(half_phase) / h, 2); };
    for (int i = 0; i < transform_.modes_x(); ++i)
        lambda_x_.push_back(T(eigenvalue(transform_.half_phase_x(i), lattice.h[0])));
    for (int j = 0; j < transform_.modes_y(); ++j)
        lambda_y_.push_back(T(eigenvalue(transform_.half_phase_y(j), lattice.h[1])));
}

template<typename T>
void Projection<T>::divergence_row(const Field<T>& u, const Field<T>& v, const Field<T>& w, int j, int k, T* out) const
{
    const double rho = rho_.centre[size_t(k)], dz = lattice_.h[2];
    divergence_clones({u ? u.row(j, k) : nullptr, v ? v.row(j, k) : nullptr, v ? v.row(j + 1, k) : nullptr, w.row(j, k),
                       w.row(j, k + 1), T(rho / lattice_.h[0]), T(rho / lattice_.h[1]), T(rho_.face[size_t(k)] / dz),
                       T(rho_.face[size_t(k) + 1] / dz)},
                      out, lattice_.n[0]);
}

template<typename T>
void Projection<T>::solve_columns(int j)
{
    constexpr int width = 64;  // of a bundle of columns, so that its scratch stays in cache
    const int nz = lattice_.n[2], modes = transform_.modes_x();
    const double dz2 = lattice_.h[2] * lattice_.h[2];
    std::vector<T> ratio(size_t(nz) * width);
    T s[width], carry[width], lambda[width];
    for (int i0 = 0; i0 < modes; i0 += width) {
        const int n = std::min(width, modes - i0);
        for (int i = 0; i < n; ++i) {
            lambda[i] = lambda_x_[size_t(i0 + i)] + lambda_y_[size_t(j)];
            s[i] = lambda[i] * T(rho_.centre[0]);
            carry[i] = T(0);
        }
        for (int k = 0; k + 1 < nz; ++k) {
            const T a = T(rho_.face[size_t(k) + 1] / dz2), rho = T(rho_.centre[size_t(k) + 1]);
            eliminate_clones(s, carry, &ratio[size_t(k) * width], phi_.row(j, k) + i0, a, T(1) / a, n);
            for (int i = 0; i < n; ++i) s[i] += lambda[i] * rho;
        }
        T* top = phi_.row(j, nz - 1) + i0;
        for (int i = 0; i < n; ++i) top[i] = s[i] > T(0) ? (carry[i] - top[i]) / s[i] : T(0);
        for (int k = nz - 2; k >= 0; --k)
            substitute_clones(&ratio[size_t(k) * width], phi_.row(j, k + 1) + i0, phi_.row(j, k) + i0, n);
    }
}

template<typename T>
void Projection<T>::correct_plane(Field<T>& u, Field<T>& v, Field<T>& w, int k)
{
    const auto [nx, ny, nz] = lattice_.n;
    const T cx = T(1 / lattice_.h[0]), cy = T(1 / lattice_.h[1]), cz = T(1 / lattice_.h[2]);
    std::vector<T> zero(size_t(nx), T(0));
    for (int j = 0; j < ny; ++j) {
        const T* p = phi_.row(j, k);
        if (k > 0) subtract_clones(w.row(j, k), p, phi_.row(j, k - 1), cz, nx);
        if (u) {
            T* row = u.row(j, k);
            subtract_clones(row + 1, p + 1, p, cx, nx - 1);
            if (lattice_.side[0] == Side::Periodic) row[0] -= (p[0] - p[nx - 1]) * cx;
            if (lattice_.side[0] == Side::Open) row[0] -= 2 * p[0] * cx, row[nx] += 2 * p[nx - 1] * cx;
        }
        if (!v) continue;
        if (j > 0)
            subtract_clones(v.row(j, k), p, phi_.row(j - 1, k), cy, nx);
        else if (lattice_.side[1] == Side::Periodic)
            subtract_clones(v.row(0, k), p, phi_.row(ny - 1, k), cy, nx);
        else if (lattice_.side[1] == Side::Open)
            subtract_clones(v.row(0, k), p, zero.data(), 2 * cy, nx);
    }
    if (v && lattice_.side[1] == Side::Open)
        subtract_clones(v.row(ny, k), zero.data(), phi_.row(ny - 1, k), 2 * cy, nx);
}

template<typename T>
void Projection<T>::solve()
{
    const auto [nx, ny, nz] = lattice_.n;
    const T scale = T(transform_.scale());
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            for (int j = 0; j < ny; ++j) {
                T* row = phi_.row(j, k);
                for (int i = 0; i < nx; ++i) row[i] *= scale;
            }
            transform_.forward(phi_.plane(k));
        }
    });
    solve_modes();
}

template<typename T>
void Projection<T>::solve_modes()
{
    for_chunks(transform_.modes_y(), plane_grain(transform_.modes_y()), [&](int j0, int j1) {
        for (int j = j0; j < j1; ++j) solve_columns(j);
    });
    for_chunks(lattice_.n[2], plane_grain(lattice_.n[2]), [&](int k0, int k1) {
        for (int k = k0; k < k1; ++k) transform_.backward(phi_.plane(k));
    });
}

template<typename T>
void Projection<T>::project(Field<T>& u, Field<T>& v, Field<T>& w)
{
    const auto [nx, ny, nz] = lattice_.n;
    const T scale = T(transform_.scale());
    const Continuation<T> beyond[] = {{lattice_, Place::FaceX}, {lattice_, Place::FaceY}, {lattice_, Place::FaceZ}};
    Field<T>* const winds[] = {&u, &v, &w};
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            for (const size_t axis : {0, 1, 2})
                if (*winds[axis]) beyond[axis].ends(*winds[axis], k);
            for (int j = 0; j < ny; ++j) {
                T* row = phi_.row(j, k);
                divergence_row(u, v, w, j, k, row);
                for (int i = 0; i < nx; ++i) row[i] *= scale;
            }
            transform_.forward(phi_.plane(k));
        }
    });
    solve_modes();
    for_chunks(nz, plane_grain(nz), [&](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            correct_plane(u, v, w, k);
            for (const size_t axis : {0, 1, 2})
                if (*winds[axis]) beyond[axis].rows(*winds[axis], k);
        }
    });
    for (const size_t axis : {0, 1, 2})
        if (*winds[axis]) beyond[axis].below_and_above(*winds[axis]);
}

template<typename T>
double Projection<T>::max_divergence(const Field<T>& u, const Field<T>& v, const Field<T>& w) const
{
    return reduce_planes(
        lattice_.n[2], 0.0,
        [&](int k) {
            std::vector<T> row(size_t(lattice_.n[0]));
            double most = 0;
            for (int j = 0; j < lattice_.n[1]; ++j) {
                divergence_row(u, v, w, j, k, row.data());
                for (const T d : row) most = std::max(most, std::abs(double(d)));
            }
            return most / rho_.centre[size_t(k)];
        },
        [](double a, double b) { return std::max(a, b); });
}

template class Planes<float>;
template class Planes<double>;
template class Projection<float>;
template class Projection<double>;

}  // namespace vdbcloud::sim
