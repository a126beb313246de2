// What eddies smaller than the cells do to the air and what it carries.
#include "vdbcloud/sim/model.h"

#include <cmath>

namespace vdbcloud::sim {

/// Smagorinsky 1963, Lilly 1962: eddy viscosity (c_s delta)^2 |S| sqrt(1 - Ri / Pr), Pr = 1/3; stresses from the full
/// strain.
template<typename T>
void Model<T>::add_subgrid()
{
    eddy_ = Field<T>(lattice_);
    before_stage_.push_back([this](int in) { find_eddy_viscosity(in); });
    if (parameters_.momentum)
        for (int c = 0; c < 3; ++c) {
            if (!wind_[size_t(c)]) continue;
            wind_[size_t(c)].stiff.push_back([this, c](int in, int j, int k, T* out) {
                const Field<T>& own = wind_[size_t(c)].a[size_t(in)];
                const int width = c == 0 ? lattice_.faces(0) : lattice_.n[0];
                const ptrdiff_t sc = own.stride(c);
                const T hc = T(1 / lattice_.h[size_t(c)]);
                const T *nu = eddy_.row(j, k), *u = own.row(j, k);
                for (int d = 0; d < 3; ++d) {
                    if (lattice_.flat(d)) continue;
                    const T hd = T(1 / lattice_.h[size_t(d)]);
                    if (c == d) {
                        for (int i = 0; i < width; ++i)
                            out[i] += 2 * hd * hd * (nu[i] * (u[i + sc] - u[i]) - nu[i - sc] * (u[i] - u[i - sc]));
                        continue;
                    }
                    const Field<T>& other = wind_[size_t(d)].a[size_t(in)];
                    const ptrdiff_t sd = own.stride(d);
                    const T* w = other.row(j, k);
                    const auto stress = [&](int i) {  // on the edge below u[i] along d
                        const ptrdiff_t a = i, b = i - sc;
                        const T edge = T(0.25) * (nu[a] + nu[b] + nu[a - sd] + nu[b - sd]);
                        return edge * (hd * (u[a] - u[a - sd]) + hc * (w[a] - w[b]));
                    };
                    for (int i = 0; i < width; ++i) out[i] += hd * (stress(int(i + sd)) - stress(i));
                }
            });
        }
    for (Variable<T>* v : scalars())
        v->stiff.push_back([this, v](int in, int j, int k, T* out) {
            const T *q = v->a[size_t(in)].row(j, k), *nu = eddy_.row(j, k);
            for (int d = 0; d < 3; ++d) {
                if (lattice_.flat(d)) continue;
                const ptrdiff_t s = eddy_.stride(d);
                const T c = T(3 * 0.5 / (lattice_.h[size_t(d)] * lattice_.h[size_t(d)]));  // 1/Pr = 3
                for (int i = 0; i < lattice_.n[0]; ++i)
                    out[i] += c * ((nu[i + s] + nu[i]) * (q[i + s] - q[i]) - (nu[i] + nu[i - s]) * (q[i] - q[i - s]));
            }
        });
}

template<typename T>
void Model<T>::find_eddy_viscosity(int at)
{
    const auto [nx, ny, nz] = lattice_.n;
    const size_t now = parameters_.momentum ? size_t(at) : 0;
    double volume = 1;
    int axes = 0;
    for (const int d : {0, 1, 2})
        if (!lattice_.flat(d)) volume *= lattice_.h[size_t(d)], ++axes;
    const double mixing = std::pow(parameters_.smagorinsky * std::pow(volume, 1.0 / axes), 2);
    // Explicit mixing is stable up to this; more would only mean that the grid is coarser than the eddies.
    double inverse = 0;
    for (const int d : {0, 1, 2})
        if (!lattice_.flat(d)) inverse += 1 / (lattice_.h[size_t(d)] * lattice_.h[size_t(d)]);
    const double cap = 0.1 / (inverse * 3 * std::max(dt_, 1e-30));

    for_blocks(nz, plane_grain(nz), [&, nx = nx, ny = ny, nz = nz](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i) {
                    double s2 = 0;
                    for (int c = 0; c < 3; ++c) {
                        if (lattice_.flat(c)) continue;
                        const Field<T>& a = wind_[size_t(c)].a[now];
                        const T* u = a.row(j, k) + i;
                        const ptrdiff_t sc = a.stride(c);
                        const double normal = (double(u[sc]) - double(u[0])) / lattice_.h[size_t(c)];
                        s2 += 2 * normal * normal;
                        for (int d = c + 1; d < 3; ++d) {
                            if (lattice_.flat(d)) continue;
                            const T* w = wind_[size_t(d)].a[now].row(j, k) + i;
                            const ptrdiff_t sd = a.stride(d);
                            // Mean over the four edges of the cell of their squared shear.
                            for (const ptrdiff_t oc : {ptrdiff_t(0), sc})
                                for (const ptrdiff_t od : {ptrdiff_t(0), sd}) {
                                    const double shear =
                                        (double(u[oc + od]) - double(u[oc + od - sd])) / lattice_.h[size_t(d)] +
                                        (double(w[oc + od]) - double(w[oc + od - sc])) / lattice_.h[size_t(c)];
                                    s2 += 0.25 * shear * shear;
                                }
                        }
                    }
                    double n2 = 0;
                    if (theta_ && parameters_.buoyancy) {
                        const Field<T>& t = theta_.a[size_t(at)];
                        const int above = std::min(k + 1, nz - 1), below = std::max(k - 1, 0);
                        if (above > below)
                            n2 = parameters_.constants.g / parameters_.constants.theta0 *
                                 (double(t(i, j, above)) - double(t(i, j, below))) / ((above - below) * lattice_.h[2]);
                    }
                    const double damped = s2 - 3 * n2;  // |S|^2 (1 - Ri/Pr)
                    eddy_(i, j, k) = T(std::min(cap, damped > 0 ? mixing * std::sqrt(damped) : 0.0));
                }
    });
    fill_halo(lattice_, Place::Centre, eddy_);
}

template void Model<float>::add_subgrid();
template void Model<double>::add_subgrid();

}  // namespace vdbcloud::sim
