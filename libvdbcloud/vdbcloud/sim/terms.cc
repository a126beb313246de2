// The effects that can be on or off. Each registers the rows it adds to a tendency, or what must be found before a
// stage; an effect that is off registers nothing.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/model.h"

#include <cmath>

namespace vdbcloud::sim {

template<typename T>
void Model<T>::add_terms()
{
    const Parameters& p = parameters_;
    add_floor_fluxes();
    if (p.viscosity > 0 || p.diffusivity > 0) add_diffusion();
    if (p.subgrid) add_subgrid();
    if (p.radiation > 0) add_radiation();
    if (p.sponge > 0 && p.momentum) add_sponge();
    if (std::isfinite(p.wind_relaxation) && p.momentum) add_wind_relaxation();
    const bool open = lattice_.side[0] == Side::Open || lattice_.side[1] == Side::Open;
    if (open && p.side_cells > 0) add_side_relaxation();
}

template<typename T>
void Model<T>::add_source(Quantity q, Source rate)
{
    Variable<T>& v = of(q);
    if (!v) throw InputError("source: this run has no field for its quantity");
    const auto place = [&](Place face) { return v.place == face ? 0.0 : 0.5; };
    const double sx = place(Place::FaceX), sy = place(Place::FaceY), sz = place(Place::FaceZ);
    const int width = v.place == Place::FaceX ? lattice_.faces(0) : lattice_.n[0];
    v.terms.push_back([this, sx, sy, sz, width, rate = std::move(rate)](int, int j, int k, T* out) {
        const auto [dx, dy, dz] = lattice_.h;
        for (int i = 0; i < width; ++i) out[i] += T(rate((i + sx) * dx, (j + sy) * dy, (k + sz) * dz, stage_time_));
    });
    if (v.place == Place::Centre) v.row_source.assign(size_t(lattice_.n[1]) * size_t(lattice_.n[2]), 0.0);
}

/// Heat, water and smoke that enter through the floor, spread over the first cell: flux / dz.
template<typename T>
void Model<T>::add_floor_fluxes()
{
    const auto [nx, ny, nz] = lattice_.n;
    const Floor& floor = parameters_.floor;
    const auto map_of = [&, nx = nx, ny = ny](double uniform, double Patch::*strength) {
        std::vector<T> map(size_t(nx) * size_t(ny));
        double most = 0;
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const size_t c = size_t(j) * size_t(nx) + size_t(i);
                double flux = uniform * (floor.map.empty() ? 1 : floor.map[c]);
                for (const Patch& patch : floor.patches) {
                    const double x = (i + 0.5) * lattice_.h[0] - patch.centre[0];
                    const double y = lattice_.flat(1) ? 0 : (j + 0.5) * lattice_.h[1] - patch.centre[1];
                    flux += patch.*strength * std::exp(-(x * x + y * y) / (patch.radius * patch.radius));
                }
                map[c] = T(flux / lattice_.h[2] / rho_.centre[0]);
                most = std::max(most, std::abs(flux));
            }
        return most > 0 ? map : std::vector<T>();
    };
    const auto add = [&, nx = nx](Variable<T>& v, std::vector<T> map) {
        if (!v || map.empty()) return;
        v.terms.push_back([this, nx, map = std::move(map)](int, int j, int k, T* out) {
            if (k > 0 || time_ >= parameters_.floor.until) return;
            for (int i = 0; i < nx; ++i) out[i] += map[size_t(j) * size_t(nx) + size_t(i)];
        });
    };
    if (theta_) add(theta_, map_of(floor.heat, &Patch::heat));
    if (water_) add(water_, map_of(floor.moisture, &Patch::moisture));
    if (dye_) add(dye_, map_of(0, &Patch::dye));
}

template<typename T>
void Model<T>::add_diffusion()
{
    const auto coefficient = [&](double k, int axis) {
        return T(lattice_.flat(axis) ? 0 : k / (lattice_.h[size_t(axis)] * lattice_.h[size_t(axis)]));
    };
    const auto add = [&](Variable<T>& v, double k, int width) {
        v.stiff.push_back([&v, width, cx = coefficient(k, 0), cy = coefficient(k, 1),
                           cz = coefficient(k, 2)](int in, int j, int level, T* out) {
            const Field<T>& q = v.a[size_t(in)];
            add_laplacian({q.row(j, level), cx == 0 ? 0 : 1, cy == 0 ? 0 : q.stride(1), q.stride(2), cx, cy, cz}, out,
                          width);
        });
    };
    const Parameters& p = parameters_;
    if (p.viscosity > 0 && p.momentum)
        for (Variable<T>* v : velocities()) add(*v, p.viscosity, v == &wind_[0] ? lattice_.faces(0) : lattice_.n[0]);
    if (p.diffusivity > 0)
        for (Variable<T>* v : scalars()) add(*v, p.diffusivity, lattice_.n[0]);
    double inverse = 0;
    for (const int axis : {0, 1, 2}) inverse += double(coefficient(1, axis));
    // Twice the sum of nu / h^2 leaves a cell at rest with what it has at 1 / rate; half of that more for stages of 4/3
    // dt.
    fastest_rate_ = std::max(fastest_rate_, std::max(p.viscosity, p.diffusivity) * inverse * 3);
}

/// Long-wave cooling: net flux F exp(-kappa LWP above); heating = -(1 / rho cp) dF/dz, of theta.
template<typename T>
void Model<T>::add_radiation()
{
    heating_ = Field<T>(lattice_);
    before_stage_.push_back([this](int in) { find_heating(in); });
    theta_.terms.push_back([this](int, int j, int k, T* out) {
        const T* rate = heating_.row(j, k);
        for (int i = 0; i < lattice_.n[0]; ++i) out[i] += rate[i];
    });
}

template<typename T>
void Model<T>::find_heating(int at)
{
    const auto [nx, ny, nz] = lattice_.n;
    const Parameters& p = parameters_;
    for_blocks(ny, 4, [&, nx = nx, nz = nz](int j0, int j1) {
        std::vector<T> cloud(static_cast<size_t>(nx));
        std::vector<double> path(static_cast<size_t>(nx));
        for (int j = j0; j < j1; ++j) {
            std::fill(path.begin(), path.end(), 0.0);
            for (int k = nz - 1; k >= 0; --k) {
                const Level& level = column_.level[size_t(k)];
                const double rho = p.constants.rho0 * rho_.centre[size_t(k)];
                thermo_.cloud_row(level, theta_.a[size_t(at)].row(j, k), water_.a[size_t(at)].row(j, k), cloud.data(),
                                  nx);
                T* out = heating_.row(j, k);
                for (int i = 0; i < nx; ++i) {
                    const double lower = path[size_t(i)] + rho * double(cloud[size_t(i)]) * lattice_.h[2];
                    const double divergence = p.radiation * (std::exp(-p.radiation_kappa * path[size_t(i)]) -
                                                             std::exp(-p.radiation_kappa * lower));
                    out[i] = T(-divergence / (rho * p.constants.cp * lattice_.h[2] * level.exner));
                    path[size_t(i)] = lower;
                }
            }
        }
    });
}

/// Rayleigh damping below the lid, so that waves are not reflected: Klemp and Lilly 1978. Velocities only: budgets
/// stay.
template<typename T>
void Model<T>::add_sponge()
{
    const int nz = lattice_.n[2];
    const double lid = nz * lattice_.h[2], start = lid * (1 - parameters_.sponge_depth);
    const auto rate = [&](double z) {
        return z <= start ? 0 : parameters_.sponge * std::pow(std::sin(M_PI / 2 * (z - start) / (lid - start)), 2);
    };
    for (int c = 0; c < 3; ++c) {
        if (!wind_[size_t(c)]) continue;
        std::vector<T> rates, targets;
        for (int k = 0; k < nz; ++k) {
            rates.push_back(T(rate((c == 2 ? k : k + 0.5) * lattice_.h[2])));
            targets.push_back(T(c == 0 ? column_.u[size_t(k)] : c == 1 ? column_.v[size_t(k)] : 0));
        }
        const int width = c == 0 ? lattice_.faces(0) : lattice_.n[0];
        wind_[size_t(c)].stiff.push_back([this, c, width, rates, targets](int in, int j, int k, T* out) {
            if (rates[size_t(k)] > 0)
                add_relaxation(out, wind_[size_t(c)].a[size_t(in)].row(j, k), targets[size_t(k)], rates[size_t(k)],
                               width);
        });
    }
    fastest_rate_ = std::max(fastest_rate_, parameters_.sponge);
}

/// The mean wind of every level returns to the environment's; eddies are left alone.
template<typename T>
void Model<T>::add_wind_relaxation()
{
    before_stage_.push_back([this](int in) { find_mean_wind(in); });
    for (const int c : {0, 1}) {
        if (!wind_[size_t(c)]) continue;
        const int width = c == 0 ? lattice_.faces(0) : lattice_.n[0];
        wind_[size_t(c)].stiff.push_back([this, c, width](int, int, int k, T* out) {
            const double mean = (c == 0 ? mean_u_ : mean_v_)[size_t(k)],
                         env = (c == 0 ? column_.u : column_.v)[size_t(k)];
            const T push = T((env - mean) / parameters_.wind_relaxation);
            for (int i = 0; i < width; ++i) out[i] += push;
        });
    }
    fastest_rate_ = std::max(fastest_rate_, 1 / parameters_.wind_relaxation);
}

template<typename T>
void Model<T>::find_mean_wind(int at)
{
    const auto [nx, ny, nz] = lattice_.n;
    mean_u_.assign(size_t(nz), 0), mean_v_.assign(size_t(nz), 0);
    for_blocks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (const int c : {0, 1}) {
                if (!wind_[size_t(c)]) continue;
                double sum = 0;
                for (int j = 0; j < ny; ++j) {
                    const T* row = wind_[size_t(c)].a[size_t(at)].row(j, k);
                    for (int i = 0; i < nx; ++i) sum += double(row[i]);
                }
                (c == 0 ? mean_u_ : mean_v_)[size_t(k)] = sum / (double(nx) * ny);
            }
    });
}

/// Near open sides everything returns to the environment, so that what leaves is not seen again.
template<typename T>
void Model<T>::add_side_relaxation()
{
    const auto weight = [&](int axis, double position) {  // position in cells from the lower end
        const int n = lattice_.n[size_t(axis)];
        if (lattice_.side[size_t(axis)] != Side::Open || lattice_.flat(axis)) return 0.0;
        const double inside = std::min(position, n - position), depth = parameters_.side_cells;
        return inside >= depth ? 0.0 : std::pow(std::cos(M_PI / 2 * inside / depth), 2);
    };
    const auto add = [&](Variable<T>& v, double shift_x, double shift_y, int width, int rows, auto environment) {
        if (!v) return;
        std::vector<T> rate;
        for (int j = 0; j < rows; ++j)
            for (int i = 0; i < width; ++i)
                rate.push_back(
                    T(std::max(weight(0, i + shift_x), weight(1, j + shift_y)) / parameters_.side_relaxation));
        std::vector<T> target;
        for (int k = 0; k < lattice_.n[2]; ++k) target.push_back(T(environment(size_t(k))));
        v.stiff.push_back([&v, width, rate, target](int in, int j, int k, T* out) {
            const T *q = v.a[size_t(in)].row(j, k), *r = &rate[size_t(j) * size_t(width)];
            for (int i = 0; i < width; ++i) out[i] -= r[i] * (q[i] - target[size_t(k)]);
        });
    };
    const int nx = lattice_.n[0], ny = lattice_.n[1];
    const auto zero = [](size_t) { return 0.0; };
    if (parameters_.momentum) {
        add(wind_[0], 0, 0.5, lattice_.faces(0), ny, [&](size_t k) { return column_.u[k]; });
        add(wind_[1], 0.5, 0, nx, lattice_.faces(1), [&](size_t k) { return column_.v[k]; });
        add(wind_[2], 0.5, 0.5, nx, ny, zero);
    }
    add(theta_, 0.5, 0.5, nx, ny, [&](size_t k) { return column_.level[k].theta_env; });
    add(water_, 0.5, 0.5, nx, ny, [&](size_t k) { return column_.level[k].q_env; });
    add(rain_, 0.5, 0.5, nx, ny, zero);
    add(dye_, 0.5, 0.5, nx, ny, zero);
    fastest_rate_ = std::max(fastest_rate_, 1 / parameters_.side_relaxation);
}

#define VDBCLOUD_TERMS(T)                                                                                              \
    template void Model<T>::add_terms();                                                                               \
    template void Model<T>::add_source(Quantity, Source);
VDBCLOUD_TERMS(float)
VDBCLOUD_TERMS(double)
#undef VDBCLOUD_TERMS

}  // namespace vdbcloud::sim
