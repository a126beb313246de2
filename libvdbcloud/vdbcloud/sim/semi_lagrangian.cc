// The step of any length: Stam 1999. Each value is fetched from where the air came from; nothing is conserved.
#include "vdbcloud/sim/model.h"

#include <cmath>

namespace vdbcloud::sim {

namespace {

/// Trilinear value at a position in index space, of a field at (0, 0, 0) = its own first point. Positions beyond the
/// halo are wrapped or clamped first.
template<typename T> double sample(const Field<T>& f, const Lattice& l, std::array<double, 3> x)
{
    const T* base = f.row(0, 0);
    double weight[3][2];
    ptrdiff_t offset = 0, step[3];
    for (const size_t d : {0, 1, 2}) {
        const int n = l.n[d];
        step[d] = f.stride(int(d));
        if (l.flat(int(d))) {
            weight[d][0] = 1, weight[d][1] = 0, step[d] = 0;
            continue;
        }
        double at = x[d];
        if (d < 2 && l.side[d] == Side::Periodic) at -= n * std::floor(at / n);
        at = std::clamp(at, -1.0, double(n));  // after wrapping, too: of 1e20 cells no fraction is left
        const double floor_at = std::min(std::floor(at), double(n - 1));
        weight[d][1] = at - floor_at, weight[d][0] = 1 - weight[d][1];
        offset += ptrdiff_t(floor_at) * step[d];
    }
    double sum = 0;
    for (const int c : {0, 1})
        for (const int b : {0, 1})
            for (const int a : {0, 1}) {
                const double w = weight[0][a] * weight[1][b] * weight[2][c];
                if (w != 0) sum += w * double(base[offset + a * step[0] + b * step[1] + c * step[2]]);
            }
    return sum;
}

}  // namespace

/// Forces, then transport along trajectories of the midpoint rule, then friction, then the projection. Stable stratification
/// acts implicitly, w <- (w + dt B) / (1 + dt^2 N^2), so that no wave can grow; instability still grows, but
/// the air fetched always lies between values that were there.
template<typename T> void Model<T>::huge_step(double dt)
{
    const auto [nx, ny, nz] = lattice_.n;
    const Parameters& p = parameters_;
    if (p.momentum && p.buoyancy) {
        find_buoyancy(0);
        Field<T>& w = wind_[2].a[0];
        const double g = p.constants.g / p.constants.theta0;
        for_blocks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
            for (int k = std::max(1, k0); k < k1; ++k)
                for (int j = 0; j < ny; ++j) {
                    const T *above = pressure_->scratch().row(j, k), *below = pressure_->scratch().row(j, k - 1);
                    for (int i = 0; i < nx; ++i) {
                        const double n2 =
                            g * (double(theta_.a[0](i, j, k)) - double(theta_.a[0](i, j, k - 1))) / lattice_.h[2];
                        const double pushed = double(w(i, j, k)) + dt * 0.5 * (double(above[i]) + double(below[i]));
                        w(i, j, k) = T(pushed / (1 + dt * dt * std::max(0.0, n2)));
                    }
                }
        });
        for (Variable<T>* v : velocities()) fill_halo(lattice_, v->place, v->a[0]);
        pressure_->project(wind_[0].a[0], wind_[1].a[0], wind_[2].a[0]);
        finish_state(0);
    }
    const auto velocity_at = [&](const std::array<double, 3>& x, int d) {  // x in cells from the box's corner
        if (lattice_.flat(d)) return 0.0;
        std::array<double, 3> at{x[0] - 0.5, x[1] - 0.5, x[2] - 0.5};
        at[size_t(d)] += 0.5;
        return sample(wind_[size_t(d)].a[0], lattice_, at) / lattice_.h[size_t(d)];
    };
    // Relaxation and diffusion that would overshoot in so long a step act as far as one step can take them.
    const T tame = T(std::min(1.0, 1 / std::max(1e-30, dt * fastest_rate_)));
    const auto transport = [&, nx = nx, ny = ny](Variable<T>& v) {
        const std::array<double, 3> shift{v.place == Place::FaceX ? 0.0 : 0.5, v.place == Place::FaceY ? 0.0 : 0.5,
                                          v.place == Place::FaceZ ? 0.0 : 0.5};
        const int width = v.place == Place::FaceX ? lattice_.faces(0) : nx;
        const int rows = v.place == Place::FaceY ? lattice_.faces(1) : ny;
        const double least = -reference(v.quantity);
        const bool water = v.quantity == Quantity::Water || v.quantity == Quantity::Rain || v.quantity == Quantity::Dye;
        const double drag = v.place == Place::Centre ? 1 : std::exp(-dt / p.friction_time);
        for_blocks(nz, 1, [&](int k, int) {
            std::vector<T> source(static_cast<size_t>(width));
            for (int j = 0; j < rows; ++j) {
                std::fill(source.begin(), source.end(), T(0));
                for (const auto& term : v.stiff) term(0, j, k, source.data());
                for (T& rate : source) rate *= tame;
                for (const auto& term : v.terms) term(0, j, k, source.data());
                for (int i = 0; i < width; ++i) {
                    const std::array<double, 3> here{i + shift[0], j + shift[1], k + shift[2]};
                    std::array<double, 3> middle = here, origin = here;
                    for (const int d : {0, 1, 2}) middle[size_t(d)] -= 0.5 * dt * velocity_at(here, d);
                    for (const int d : {0, 1, 2}) origin[size_t(d)] -= dt * velocity_at(middle, d);
                    for (const size_t d : {0, 1, 2}) {  // nothing comes through rigid walls
                        if (d == 2 || lattice_.side[d] == Side::Wall)
                            origin[d] = std::clamp(origin[d], std::min(0.5, shift[d]), lattice_.n[d] - std::min(0.5, shift[d]));
                        origin[d] -= shift[d];
                    }
                    const double value = drag * sample(v.a[0], lattice_, origin) + dt * double(source[size_t(i)]);
                    v.a[1](i, j, k) = T(water ? std::max(least, value) : value);
                }
            }
        });
    };
    stage_time_ = time_;
    for (const auto& prepare : before_stage_) prepare(0);
    for (Variable<T>* v : scalars()) transport(*v);
    if (p.momentum)
        for (Variable<T>* v : velocities()) transport(*v);
    for (Variable<T>* v : scalars()) v->a[0].swap(v->a[1]);
    if (p.momentum) {
        for (Variable<T>* v : velocities()) v->a[0].swap(v->a[1]);
        for (Variable<T>* v : velocities()) fill_halo(lattice_, v->place, v->a[0]);
        pressure_->project(wind_[0].a[0], wind_[1].a[0], wind_[2].a[0]);
    }
    finish_state(0);
    if (p.momentum) take_courant(0);
    if (p.rain) rain(dt);
}

template void Model<float>::huge_step(double);
template void Model<double>::huge_step(double);

}  // namespace vdbcloud::sim
