// Mixing by eddies smaller than the cells, after Smagorinsky 1963 and Lilly 1962: eddy viscosity
//
//     nu = (c_s delta)^2 |S| sqrt(1 - Ri / Pr),   Pr = 1/3,   Ri = N^2 / |S|^2,   delta^3 = dx dy dz
//
// with stresses of the wind from the full strain, and diffusivity nu / Pr of scalars.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// |S|^2 = 2 S_ij S_ij of cell (i, j, k) [1/s^2]: normal strains of the cell, shear as the mean of the squares on its
/// four edges of each direction.
template<typename T>
double squared_strain(const Air<T>& air, size_t now, int i, int j, int k)
{
    const Lattice& l = air.lattice;
    double s2 = 0;
    for (int c = 0; c < 3; ++c) {
        if (l.flat(c)) continue;
        const Field<T>& a = air.wind[size_t(c)].a[now];
        const T* u = a.row(j, k) + i;
        const ptrdiff_t sc = a.stride(c);
        const double normal = (double(u[sc]) - double(u[0])) / l.h[size_t(c)];
        s2 += 2 * normal * normal;
        for (int d = c + 1; d < 3; ++d) {
            if (l.flat(d)) continue;
            const T* w = air.wind[size_t(d)].a[now].row(j, k) + i;
            const ptrdiff_t sd = a.stride(d);
            for (const ptrdiff_t oc : {ptrdiff_t(0), sc})
                for (const ptrdiff_t od : {ptrdiff_t(0), sd}) {
                    const double shear = (double(u[oc + od]) - double(u[oc + od - sd])) / l.h[size_t(d)] +
                                         (double(w[oc + od]) - double(w[oc + od - sc])) / l.h[size_t(c)];
                    s2 += 0.25 * shear * shear;
                }
        }
    }
    return s2;
}

/// N^2 of cell (i, j, k) [1/s^2], one-sided at floor and lid.
template<typename T>
double stratification(const Air<T>& air, int at, int i, int j, int k)
{
    if (!air.theta || !air.parameters.buoyancy) return 0;
    const Field<T>& t = air.theta.a[size_t(at)];
    const int above = std::min(k + 1, air.lattice.n[2] - 1), below = std::max(k - 1, 0);
    if (above <= below) return 0;
    return air.parameters.constants.g / air.parameters.constants.theta0 *
           (double(t(i, j, above)) - double(t(i, j, below))) / ((above - below) * air.lattice.h[2]);
}

template<typename T>
void find_eddy_viscosity(const Air<T>& air, int at, Field<T>& eddy)
{
    const auto [nx, ny, nz] = air.lattice.n;
    const size_t now = air.wind_at(at);
    double volume = 1, inverse = 0;
    int axes = 0;
    for (const size_t d : {0, 1, 2}) {
        if (air.lattice.flat(int(d))) continue;
        volume *= air.lattice.h[d], ++axes;
        inverse += 1 / (air.lattice.h[d] * air.lattice.h[d]);
    }
    const double mixing = std::pow(air.parameters.smagorinsky * std::pow(volume, 1.0 / axes), 2);
    // Explicit mixing is stable up to this; more would only mean that the grid is coarser than the eddies.
    const double cap = 0.1 / (inverse * 3 * std::max(air.dt, 1e-30));
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i) {
                    const double s2 = squared_strain(air, now, i, j, k), n2 = stratification(air, at, i, j, k);
                    const double damped = s2 - 3 * n2;  // |S|^2 (1 - Ri/Pr)
                    eddy(i, j, k) = T(std::min(cap, damped > 0 ? mixing * std::sqrt(damped) : 0.0));
                }
    });
    fill_halo(air.lattice, Place::Centre, eddy);
}

/// Adds d/dx_d [nu (du_c/dx_d + du_d/dx_c)] to a row of component c.
template<typename T>
void add_stress(const Air<T>& air, int c, int in, int j, int k, const Field<T>& eddy, T* out)
{
    const Field<T>& own = air.wind[size_t(c)].a[size_t(in)];
    const int width = air.wind_width(c);
    const ptrdiff_t sc = own.stride(c);
    const T hc = T(1 / air.lattice.h[size_t(c)]);
    const T *nu = eddy.row(j, k), *u = own.row(j, k);
    for (int d = 0; d < 3; ++d) {
        if (air.lattice.flat(d)) continue;
        const T hd = T(1 / air.lattice.h[size_t(d)]);
        if (c == d) {
            for (int i = 0; i < width; ++i)
                out[i] += 2 * hd * hd * (nu[i] * (u[i + sc] - u[i]) - nu[i - sc] * (u[i] - u[i - sc]));
            continue;
        }
        const Field<T>& other = air.wind[size_t(d)].a[size_t(in)];
        const ptrdiff_t sd = own.stride(d);
        const T* w = other.row(j, k);
        const auto stress = [&](int i) {  // on the edge below u[i] along d
            const ptrdiff_t a = i, b = i - sc;
            const T edge = T(0.25) * (nu[a] + nu[b] + nu[a - sd] + nu[b - sd]);
            return edge * (hd * (u[a] - u[a - sd]) + hc * (w[a] - w[b]));
        };
        for (int i = 0; i < width; ++i) out[i] += hd * (stress(int(i + sd)) - stress(i));
    }
}

/// Adds div(nu / Pr grad q) to a row of a scalar.
template<typename T>
void add_eddy_diffusion(const Air<T>& air, const Field<T>& scalar, int j, int k, const Field<T>& eddy, T* out)
{
    const T *q = scalar.row(j, k), *nu = eddy.row(j, k);
    for (int d = 0; d < 3; ++d) {
        if (air.lattice.flat(d)) continue;
        const ptrdiff_t s = eddy.stride(d);
        const T c = T(3 * 0.5 / (air.lattice.h[size_t(d)] * air.lattice.h[size_t(d)]));  // 1/Pr = 3
        for (int i = 0; i < air.lattice.n[0]; ++i)
            out[i] += c * ((nu[i + s] + nu[i]) * (q[i + s] - q[i]) - (nu[i] + nu[i - s]) * (q[i] - q[i - s]));
    }
}

template<typename T>
void add(Air<T>& air)
{
    Field<T>& eddy = air.add_field();
    air.before_stage.push_back([&air, &eddy](int in) { find_eddy_viscosity(air, in, eddy); });
    if (air.parameters.momentum)
        for (int c = 0; c < 3; ++c)
            if (air.wind[size_t(c)])
                air.wind[size_t(c)].stiff.push_back(
                    [&air, &eddy, c](int in, int j, int k, T* out) { add_stress(air, c, in, j, k, eddy, out); });
    for (Variable<T>* v : air.scalars())
        v->stiff.push_back([&air, &eddy, v](int in, int j, int k, T* out) {
            add_eddy_diffusion(air, v->a[size_t(in)], j, k, eddy, out);
        });
}

}  // namespace

Effect subgrid()
{
    return changeable({"sub-grid mixing",
                       "eddy viscosity, strain",
                       {{"subgrid", "eddies smaller than the cells mix, after Smagorinsky and Lilly",
                         [](Parameters& p) -> bool& { return p.subgrid; }},
                        {"smagorinsky", "coefficient c_s of sub-grid mixing", "", from_zero(10),
                         [](Parameters& p) -> double& { return p.smagorinsky; }}},
                       [](const Parameters& p) { return p.subgrid; },
                       nullptr,
                       [](const Parameters&) { return 1; },
                       {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
