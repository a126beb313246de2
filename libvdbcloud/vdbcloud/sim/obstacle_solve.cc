#include "vdbcloud/sim/obstacle_solve.h"

#include "vdbcloud/sim/parallel.h"

#include <cmath>

namespace vdbcloud::sim {

namespace {

constexpr int sweeps = 2;            // of Jacobi, before the direct solve of the box and after it
constexpr double damping = 2.0 / 3;  // of these

/// 1 / (h^2) with the densities of an anelastic base, of the faces below and above plane k.
struct Coefficients {
    double x, y, below, above;
};
Coefficients coefficients(const Lattice& l, const BaseDensity& rho, int k)
{
    const double z = 1 / (l.h[2] * l.h[2]), centre = rho.centre[size_t(k)];
    return {l.flat(0) ? 0 : centre / (l.h[0] * l.h[0]), l.flat(1) ? 0 : centre / (l.h[1] * l.h[1]),
            z * rho.face[size_t(k)], z * rho.face[size_t(k) + 1]};
}

}  // namespace

template<typename T>
ObstacleSolve<T>::ObstacleSolve(const Lattice& lattice, const BaseDensity& rho, Projection<T>& box, Openness<T>& open)
    : lattice_(lattice), rho_(rho), box_(box), open_(open), x_(lattice), r_(lattice), p_(lattice), q_(lattice),
      z_(lattice), damped_(lattice)
{
    const auto [nx, ny, nz] = lattice.n;
    for (int k = 0; k < nz; ++k) {
        const Coefficients c = coefficients(lattice, rho, k);
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const auto share = [&](int axis, int a, int b, int d) {
                    return open_.face[size_t(axis)] ? double(open_.face[size_t(axis)](a, b, d)) : 1.0;
                };
                const double ends_x = lattice.side[0] == Side::Open, ends_y = lattice.side[1] == Side::Open;
                const double diagonal = c.x * (share(0, i, j, k) * (1 + ends_x * (i == 0)) +
                                               share(0, i + 1, j, k) * (1 + ends_x * (i == nx - 1))) +
                                        c.y * (share(1, i, j, k) * (1 + ends_y * (j == 0)) +
                                               share(1, i, j + 1, k) * (1 + ends_y * (j == ny - 1))) +
                                        c.below * share(2, i, j, k) +
                                        (k + 1 < nz ? c.above * share(2, i, j, k + 1) : 0);
                damped_(i, j, k) = diagonal > 0 ? T(damping / diagonal) : T(0);
            }
    }
}

/// Sets the velocity of closed faces to 0, and that of the faces at the ends of axes that are not computed.
template<typename T>
void ObstacleSolve<T>::close(Field<T>& u, Field<T>& v, Field<T>& w) const
{
    const auto [nx, ny, nz] = lattice_.n;
    Field<T>* const winds[] = {&u, &v, &w};
    const Place places[] = {Place::FaceX, Place::FaceY, Place::FaceZ};
    for (const size_t axis : {0, 1, 2}) {
        if (!*winds[axis]) continue;
        const Continuation<T> beyond(lattice_, places[axis]);
        for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
            for (int k = k0; k < k1; ++k) {
                for (int j = 0; j < ny + (axis == 1); ++j) {
                    T* row = winds[axis]->row(j, k);
                    const T* share = open_.face[axis].row(j, k);
                    for (int i = 0; i < nx + (axis == 0); ++i)
                        if (!(share[i] > T(0))) row[i] = T(0);
                }
                beyond.ends(*winds[axis], k);
            }
        });
    }
}

template<typename T>
void ObstacleSolve<T>::set_flux(const Field<T>& u, const Field<T>& v, const Field<T>& w)
{
    const Field<T>* const winds[] = {&u, &v, &w};
    const Place places[] = {Place::FaceX, Place::FaceY, Place::FaceZ};
    const auto [nx, ny, nz] = lattice_.n;
    for (const size_t axis : {0, 1, 2}) {
        if (!*winds[axis]) continue;
        for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
            for (int k = k0; k < k1; ++k)
                for (int j = 0; j < ny + (axis == 1); ++j) {
                    const T *row = winds[axis]->row(j, k), *share = open_.face[axis].row(j, k);
                    T* out = open_.flux[axis].row(j, k);
                    for (int i = 0; i < nx + (axis == 0); ++i) out[i] = share[i] * row[i];
                }
        });
        fill_halo(lattice_, places[axis], open_.flux[axis]);
    }
}

/// out = -div(rho a V) of the fluxes. Returns the largest absolute value.
template<typename T>
double ObstacleSolve<T>::residual(Field<T>& out) const
{
    const auto [nx, ny, nz] = lattice_.n;
    return reduce_planes(
        nz, 0.0,
        [&, nx = nx, ny = ny](int k) {
            const double rho = rho_.centre[size_t(k)];
            const T cx = T(rho / lattice_.h[0]), cy = T(rho / lattice_.h[1]);
            const T cb = T(rho_.face[size_t(k)] / lattice_.h[2]), ct = T(rho_.face[size_t(k) + 1] / lattice_.h[2]);
            double most = 0;
            for (int j = 0; j < ny; ++j) {
                T* row = out.row(j, k);
                const T *below = open_.flux[2].row(j, k), *above = open_.flux[2].row(j, k + 1);
                for (int i = 0; i < nx; ++i) row[i] = cb * below[i] - ct * above[i];
                if (open_.flux[0]) {
                    const T* f = open_.flux[0].row(j, k);
                    for (int i = 0; i < nx; ++i) row[i] -= cx * (f[i + 1] - f[i]);
                }
                if (open_.flux[1]) {
                    const T *s = open_.flux[1].row(j, k), *n = open_.flux[1].row(j + 1, k);
                    for (int i = 0; i < nx; ++i) row[i] -= cy * (n[i] - s[i]);
                }
                for (int i = 0; i < nx; ++i) most = std::max(most, std::abs(double(row[i])) / rho);
            }
            return most;
        },
        [](double a, double b) { return std::max(a, b); });
}

/// One value beyond each end: of the opposite cell, or the negative of the last where the pressure is 0 on the face.
template<typename T>
void ObstacleSolve<T>::fill_ghosts(Field<T>& p) const
{
    const auto [nx, ny, nz] = lattice_.n;
    const bool open_x = lattice_.side[0] == Side::Open, open_y = lattice_.side[1] == Side::Open;
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            if (!lattice_.flat(0))
                for (int j = 0; j < ny; ++j) {
                    T* row = p.row(j, k);
                    row[-1] = open_x ? -row[0] : row[nx - 1], row[nx] = open_x ? -row[nx - 1] : row[0];
                }
            if (lattice_.flat(1)) continue;
            T *south = p.row(-1, k), *north = p.row(ny, k);
            const T *first = p.row(0, k), *last = p.row(ny - 1, k);
            for (int i = 0; i < nx; ++i) {
                south[i] = open_y ? -first[i] : last[i];
                north[i] = open_y ? -last[i] : first[i];
            }
        }
    });
}

/// out = -div(rho a grad p). Fills the ghosts of p.
template<typename T>
void ObstacleSolve<T>::apply(Field<T>& p, Field<T>& out) const
{
    fill_ghosts(p);
    const auto [nx, ny, nz] = lattice_.n;
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny, nz = nz](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            const Coefficients c = coefficients(lattice_, rho_, k);
            const T cx = T(c.x), cy = T(c.y), cb = T(c.below), ct = T(k + 1 < nz ? c.above : 0);
            for (int j = 0; j < ny; ++j) {
                const T *m = p.row(j, k), *below = p.row(j, k - 1), *above = p.row(j, k + 1);
                const T *ab = open_.face[2].row(j, k), *at = open_.face[2].row(j, k + 1);
                T* o = out.row(j, k);
                for (int i = 0; i < nx; ++i) o[i] = cb * ab[i] * (m[i] - below[i]) + ct * at[i] * (m[i] - above[i]);
                if (open_.face[0]) {
                    const T* a = open_.face[0].row(j, k);
                    for (int i = 0; i < nx; ++i) o[i] += cx * (a[i] * (m[i] - m[i - 1]) + a[i + 1] * (m[i] - m[i + 1]));
                }
                if (!open_.face[1]) continue;
                const T *as = open_.face[1].row(j, k), *an = open_.face[1].row(j + 1, k);
                const T *s = p.row(j - 1, k), *n = p.row(j + 1, k);
                for (int i = 0; i < nx; ++i) o[i] += cy * (as[i] * (m[i] - s[i]) + an[i] * (m[i] - n[i]));
            }
        }
    });
}

template<typename T>
template<typename F>
void ObstacleSolve<T>::for_rows(const F& f) const
{
    for_chunks(lattice_.n[2], plane_grain(lattice_.n[2]), [&](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < lattice_.n[1]; ++j) f(j, k, lattice_.n[0]);
    });
}

/// z <- the preconditioned residual: damped Jacobi sweeps, the box, and as many sweeps again, so that it is symmetric.
template<typename T>
void ObstacleSolve<T>::precondition()
{
    const auto sweep = [&] {
        apply(z_, q_);
        for_rows([&](int j, int k, int n) {
            T* z = z_.row(j, k);
            const T *r = r_.row(j, k), *q = q_.row(j, k), *d = damped_.row(j, k);
            for (int i = 0; i < n; ++i) z[i] += d[i] * (r[i] - q[i]);
        });
    };
    for_rows([&](int j, int k, int n) {
        T* z = z_.row(j, k);
        const T *r = r_.row(j, k), *d = damped_.row(j, k);
        for (int i = 0; i < n; ++i) z[i] = d[i] * r[i];
    });
    for (int s = 1; s < sweeps; ++s) sweep();
    apply(z_, q_);
    Planes<T>& box = box_.scratch();
    for_rows([&](int j, int k, int n) {
        const T *r = r_.row(j, k), *q = q_.row(j, k);
        T* to = box.row(j, k);
        for (int i = 0; i < n; ++i) to[i] = q[i] - r[i];
    });
    box_.solve();
    for_rows([&](int j, int k, int n) {
        const T* from = box.row(j, k);
        T* z = z_.row(j, k);
        for (int i = 0; i < n; ++i) z[i] += from[i];
    });
    for (int s = 0; s < sweeps; ++s) sweep();
}

template<typename T>
double ObstacleSolve<T>::dot(const Field<T>& a, const Field<T>& b) const
{
    return reduce_planes(
        lattice_.n[2], 0.0,
        [&](int k) {
            double sum = 0;
            for (int j = 0; j < lattice_.n[1]; ++j) {
                const T *x = a.row(j, k), *y = b.row(j, k);
                for (int i = 0; i < lattice_.n[0]; ++i) sum += double(x[i]) * double(y[i]);
            }
            return sum;
        },
        [](double x, double y) { return x + y; });
}

/// x <- the solution for the residual r, to max |r| / rho <= tolerance. Returns false where iterations end first.
template<typename T>
bool ObstacleSolve<T>::solve(double tolerance)
{
    const auto [nx, ny, nz] = lattice_.n;
    for_rows([&](int j, int k, int n) {
        std::fill_n(x_.row(j, k), n, T(0));
        std::fill_n(p_.row(j, k), n, T(0));
    });
    double before = 0;
    for (int step = 0; step < 100; ++step) {
        precondition();
        const double rz = dot(r_, z_);
        if (!(rz > 0)) return true;
        const T beta = T(step > 0 ? rz / before : 0);
        before = rz;
        for_rows([&](int j, int k, int n) {
            T* p = p_.row(j, k);
            const T* d = z_.row(j, k);
            for (int i = 0; i < n; ++i) p[i] = d[i] + beta * p[i];
        });
        apply(p_, q_);
        const double curvature = dot(p_, q_);
        if (!(curvature > 0)) return true;
        ++iterations_;
        const T alpha = T(rz / curvature);
        for_rows([&](int j, int k, int n) {
            T *x = x_.row(j, k), *r = r_.row(j, k);
            const T *p = p_.row(j, k), *q = q_.row(j, k);
            for (int i = 0; i < n; ++i) x[i] += alpha * p[i], r[i] -= alpha * q[i];
        });
        const double largest = reduce_planes(
            nz, 0.0,
            [&, nx = nx, ny = ny](int k) {
                double most = 0;
                for (int j = 0; j < ny; ++j)
                    for (int i = 0; i < nx; ++i) most = std::max(most, std::abs(double(r_(i, j, k))));
                return most / rho_.centre[size_t(k)];
            },
            [](double a, double b) { return std::max(a, b); });
        if (largest <= tolerance) return true;
    }
    return false;
}

/// V -= grad x on open faces, and V = 0 on closed ones.
template<typename T>
void ObstacleSolve<T>::correct(Field<T>& u, Field<T>& v, Field<T>& w)
{
    fill_ghosts(x_);
    const auto [nx, ny, nz] = lattice_.n;
    Field<T>* const winds[] = {&u, &v, &w};
    for (const size_t axis : {0, 1, 2}) {
        if (!*winds[axis]) continue;
        const T c = T(1 / lattice_.h[axis]);
        const ptrdiff_t back = x_.stride(int(axis));
        const int width = axis == 0 ? lattice_.faces(0) : nx, count = axis == 1 ? lattice_.faces(1) : ny;
        for_chunks(nz, plane_grain(nz), [&](int k0, int k1) {
            for (int k = k0; k < k1; ++k)
                for (int j = 0; j < count; ++j) {
                    const T *phi = x_.row(j, k), *share = open_.face[axis].row(j, k);
                    T* row = winds[axis]->row(j, k);
                    for (int i = 0; i < width; ++i)
                        row[i] = share[i] > T(0) ? row[i] - c * (phi[i] - phi[i - back]) : T(0);
                }
        });
    }
}

template<typename T>
void ObstacleSolve<T>::project(Field<T>& u, Field<T>& v, Field<T>& w, double scale)
{
    double longest = 0, shortest = never;
    for (const size_t d : {0, 1, 2}) {
        longest = std::max(longest, lattice_.n[d] * lattice_.h[d]);
        if (!lattice_.flat(int(d))) shortest = std::min(shortest, lattice_.h[d]);
    }
    // A tenth of the divergence that a budget may have: a few iterations more would meet rounding.
    const double relative =
        sizeof(T) == 4 ? std::max(1e-6, 2.4e-8 * longest / shortest) : std::max(1e-13, 4.5e-17 * longest / shortest);
    const double tolerance = relative * scale / shortest;
    close(u, v, w);
    set_flux(u, v, w);
    // Rounding of the sums parts the residual of the iteration from that of the velocity: it is taken anew.
    for (int again = 0; again < 4 && residual(r_) > tolerance; ++again) {
        solve(0.5 * tolerance);
        correct(u, v, w);
        close(u, v, w);
        set_flux(u, v, w);
    }
    Field<T>* const winds[] = {&u, &v, &w};
    const Place places[] = {Place::FaceX, Place::FaceY, Place::FaceZ};
    for (const size_t axis : {0, 1, 2})
        if (*winds[axis]) fill_halo(lattice_, places[axis], *winds[axis]);
}

template<typename T>
size_t ObstacleSolve<T>::bytes() const
{
    return open_.bytes() + x_.bytes() + r_.bytes() + p_.bytes() + q_.bytes() + z_.bytes() + damped_.bytes();
}

template class ObstacleSolve<float>;
template class ObstacleSolve<double>;

}  // namespace vdbcloud::sim
