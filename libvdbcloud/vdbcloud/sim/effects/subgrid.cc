// Mixing by eddies smaller than the cells, after Smagorinsky 1963 and Lilly 1962: eddy viscosity
//
//     nu = (c_s delta)^2 |S| sqrt(1 - Ri / Pr),   Pr = 1/3,   Ri = N^2 / |S|^2,   delta^3 = dx dy dz
//
// with stresses of the wind from the full strain, and diffusivity nu / Pr of scalars.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/extremes.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Squared shear (du/dy + dv/dx)^2 on the edges below u[i] along y and below v[i] along x, and so for each pair of
/// axes. `along`: the stride of u's own axis; `across`: that of the other, along which v blows.
template<typename T>
struct ShearRow {
    const T *u, *v;
    ptrdiff_t along, across;
    T per_along, per_across;  ///< 1 / spacing
};
template<typename T>
VDBCLOUD_INLINE void squared_shear_row(const ShearRow<T>& s, T* __restrict out, int n)
{
    const T *u = s.u, *v = s.v;
    for (int i = 0; i < n; ++i) {
        const T shear = (u[i] - u[i - s.across]) * s.per_across + (v[i] - v[i - s.along]) * s.per_along;
        out[i] = shear * shear;
    }
}

/// out[i] += 2 ((u[i + along] - u[i]) / spacing)^2
template<typename T>
VDBCLOUD_INLINE void add_squared_strain_row(const T* u, ptrdiff_t along, T per, T* __restrict out, int n)
{
    for (int i = 0; i < n; ++i) {
        const T strain = (u[i + along] - u[i]) * per;
        out[i] += T(2) * (strain * strain);
    }
}

/// out[i] += 1/4 of the sum of four edges
template<typename T>
VDBCLOUD_INLINE void add_mean_row(const T* a, const T* b, const T* c, const T* d, T* __restrict out, int n)
{
    for (int i = 0; i < n; ++i) out[i] += T(0.25) * ((a[i] + b[i]) + (c[i] + d[i]));
}

/// nu[i] = min(cap, mixing sqrt(|S|^2 - 3 N^2)), N^2 = buoyancy (above - below); 0 where the root has no value.
template<typename T>
struct EddyRow {
    const T *squared_strain, *above, *below;  ///< above and below null: no stratification
    T buoyancy, mixing, cap;
};
template<typename T>
VDBCLOUD_INLINE void eddy_row(const EddyRow<T>& e, T* __restrict nu, int n)
{
    if (e.above)
        for (int i = 0; i < n; ++i)
            nu[i] = e.squared_strain[i] - T(3) * (e.buoyancy * (e.above[i] - e.below[i]));  // |S|^2 (1 - Ri/Pr)
    else
        for (int i = 0; i < n; ++i) nu[i] = e.squared_strain[i];
    for (int i = 0; i < n; ++i) nu[i] = least(e.mixing * std::sqrt(most(nu[i], T(0))), e.cap);
}

/// out[i] += per^2 times twice the divergence of nu du/dx along u's own axis
template<typename T>
VDBCLOUD_INLINE void add_normal_stress_row(const T* u, const T* nu, ptrdiff_t along, T per, T* __restrict out, int n)
{
    for (int i = 0; i < n; ++i)
        out[i] += 2 * per * per * (nu[i] * (u[i + along] - u[i]) - nu[i - along] * (u[i] - u[i - along]));
}

/// out[i] += the divergence, across u's axis, of the stress nu (du/dy + dv/dx) on the edges of `s`.
template<typename T>
VDBCLOUD_INLINE void add_shear_stress_row(const ShearRow<T>& s, const T* nu, T* __restrict out, int n)
{
    const T *u = s.u, *v = s.v;
    const ptrdiff_t along = s.along, across = s.across;
    const T pa = s.per_along, pc = s.per_across;
    const auto stress = [=](ptrdiff_t a) __attribute__((always_inline))
    {
        const T edge = T(0.25) * (nu[a] + nu[a - along] + nu[a - across] + nu[a - along - across]);
        return edge * (pc * (u[a] - u[a - across]) + pa * (v[a] - v[a - along]));
    };
    for (int i = 0; i < n; ++i) out[i] += pc * (stress(i + across) - stress(i));
}

/// out[i] += c ((nu[i + s] + nu[i]) (q[i + s] - q[i]) - the same one cell below)
template<typename T>
VDBCLOUD_INLINE void add_diffusion_row(const T* q, const T* nu, ptrdiff_t s, T c, T* __restrict out, int n)
{
    for (int i = 0; i < n; ++i)
        out[i] += c * ((nu[i + s] + nu[i]) * (q[i + s] - q[i]) - (nu[i] + nu[i - s]) * (q[i] - q[i - s]));
}

#define VDBCLOUD_EDDY_ROWS(T)                                                                                          \
    VDBCLOUD_WIDE_CLONES void squared_shear(const ShearRow<T>& s, T* out, int n) { squared_shear_row(s, out, n); }     \
    VDBCLOUD_WIDE_CLONES void add_squared_strain(const T* u, ptrdiff_t along, T per, T* out, int n)                    \
    {                                                                                                                  \
        add_squared_strain_row(u, along, per, out, n);                                                                 \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void add_mean(const T* a, const T* b, const T* c, const T* d, T* out, int n)                  \
    {                                                                                                                  \
        add_mean_row(a, b, c, d, out, n);                                                                              \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void eddy(const EddyRow<T>& e, T* nu, int n) { eddy_row(e, nu, n); }                          \
    VDBCLOUD_WIDE_CLONES void add_normal_stress(const T* u, const T* nu, ptrdiff_t along, T per, T* out, int n)        \
    {                                                                                                                  \
        add_normal_stress_row(u, nu, along, per, out, n);                                                              \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void add_shear_stress(const ShearRow<T>& s, const T* nu, T* out, int n)                       \
    {                                                                                                                  \
        add_shear_stress_row(s, nu, out, n);                                                                           \
    }                                                                                                                  \
    VDBCLOUD_WIDE_CLONES void add_diffusion(const T* q, const T* nu, ptrdiff_t s, T c, T* out, int n)                  \
    {                                                                                                                  \
        add_diffusion_row(q, nu, s, c, out, n);                                                                        \
    }
VDBCLOUD_EDDY_ROWS(float)
VDBCLOUD_EDDY_ROWS(double)
#undef VDBCLOUD_EDDY_ROWS

/// The edges of u along `c` and of v along `d` beside row (j, k).
template<typename T>
ShearRow<T> shear_at(const Air<T>& air, size_t now, int c, int d, int j, int k)
{
    const Field<T>&u = air.wind[size_t(c)].a[now], &v = air.wind[size_t(d)].a[now];
    return {u.row(j, k),
            v.row(j, k),
            u.stride(c),
            u.stride(d),
            T(1 / air.lattice.h[size_t(c)]),
            T(1 / air.lattice.h[size_t(d)])};
}

/// |S|^2 = 2 S_ij S_ij of the cells of a row [1/s^2]: normal strains of the cell, shear as the mean of the squares on its
/// four edges of each direction.
template<typename T>
class SquaredStrain {
public:
    SquaredStrain(const Air<T>& air, size_t now) : air_(air), now_(now)
    {
        for (std::vector<T>& edge : edges_) edge.resize(size_t(air.lattice.n[0]) + 1);
    }

    void find(int j, int k, T* out)
    {
        const int n = air_.lattice.n[0];
        std::fill_n(out, n, T(0));
        for (int c = 0; c < 3; ++c) {
            if (air_.lattice.flat(c)) continue;
            const Field<T>& u = air_.wind[size_t(c)].a[now_];
            add_squared_strain(u.row(j, k), u.stride(c), T(1 / air_.lattice.h[size_t(c)]), out, n);
            for (int d = c + 1; d < 3; ++d)
                if (!air_.lattice.flat(d)) add_shear(c, d, j, k, out);
        }
    }

private:
    void add_shear(int c, int d, int j, int k, T* out)
    {
        const int n = air_.lattice.n[0];
        T *a = edges_[0].data(), *b = edges_[1].data();
        const auto at = [&](int dj, int dk) { return shear_at(air_, now_, c, d, j + dj, k + dk); };
        if (c == 0) {  // edges at i and i + 1
            squared_shear(at(0, 0), a, n + 1);
            squared_shear(d == 1 ? at(1, 0) : at(0, 1), b, n + 1);
            return add_mean(a, a + 1, b, b + 1, out, n);
        }
        T *e = edges_[2].data(), *f = edges_[3].data();
        squared_shear(at(0, 0), a, n), squared_shear(at(1, 0), b, n);
        squared_shear(at(0, 1), e, n), squared_shear(at(1, 1), f, n);
        add_mean(a, b, e, f, out, n);
    }

    const Air<T>& air_;
    size_t now_;
    std::array<std::vector<T>, 4> edges_;
};

template<typename T>
void find_eddy_viscosity(const Air<T>& air, int at, Field<T>& field)
{
    const auto [nx, ny, nz] = air.lattice.n;
    const size_t now = air.wind_at(at);
    double volume = 1;
    int axes = 0;
    for (const size_t d : {0, 1, 2})
        if (!air.lattice.flat(int(d))) volume *= air.lattice.h[d], ++axes;
    const double mixing = std::pow(air.parameters.smagorinsky * std::pow(volume, 1.0 / axes), 2);
    // Explicit mixing is stable up to this; more would only mean that the grid is coarser than the eddies.
    const double cap = 0.1 / (mixing_rate(air.parameters, 1) * std::max(air.dt, 1e-30));
    const bool stratified = air.theta && air.parameters.buoyancy;
    const Continuation<T> beyond(air.lattice, Place::Centre, 1);  // stresses read one cell beside their row
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny, nz = nz](int k0, int k1) {
        SquaredStrain<T> strain(air, now);
        std::vector<T> squared(static_cast<size_t>(nx));
        for (int k = k0; k < k1; ++k) {
            // N^2 of centred differences, one-sided at floor and lid.
            const int above = std::min(k + 1, nz - 1), below = std::max(k - 1, 0);
            const double buoyancy =
                air.parameters.constants.g / air.parameters.constants.theta0 / ((above - below) * air.lattice.h[2]);
            for (int j = 0; j < ny; ++j) {
                strain.find(j, k, squared.data());
                EddyRow<T> row{squared.data(), nullptr, nullptr, T(buoyancy), T(mixing), T(cap)};
                if (stratified && above > below)
                    row.above = air.theta.a[size_t(at)].row(j, above),
                    row.below = air.theta.a[size_t(at)].row(j, below);
                eddy(row, field.row(j, k), nx);
            }
            beyond.rows(field, k);
        }
    });
    beyond.below_and_above(field);
}

/// Adds d/dx_d [nu (du_c/dx_d + du_d/dx_c)] to a row of component c.
template<typename T>
void add_stress(const Air<T>& air, int c, int in, int j, int k, const Field<T>& field, T* out)
{
    const Field<T>& own = air.wind[size_t(c)].a[size_t(in)];
    const int width = air.wind_width(c);
    for (int d = 0; d < 3; ++d) {
        if (air.lattice.flat(d)) continue;
        if (c == d)
            add_normal_stress(own.row(j, k), field.row(j, k), own.stride(c), T(1 / air.lattice.h[size_t(c)]), out,
                              width);
        else
            add_shear_stress(shear_at(air, size_t(in), c, d, j, k), field.row(j, k), out, width);
    }
}

/// Adds div(nu / Pr grad q) to a row of a scalar.
template<typename T>
void add_eddy_diffusion(const Air<T>& air, const Field<T>& scalar, int j, int k, const Field<T>& field, T* out)
{
    for (int d = 0; d < 3; ++d) {
        if (air.lattice.flat(d)) continue;
        const double h = air.lattice.h[size_t(d)];
        add_diffusion(scalar.row(j, k), field.row(j, k), field.stride(d), T(3 * 0.5 / (h * h)), out,  // 1/Pr = 3
                      air.lattice.n[0]);
    }
}

template<typename T>
void add(Air<T>& air)
{
    Field<T>& eddy = air.add_field();
    air.eddy_viscosity = &eddy;
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
