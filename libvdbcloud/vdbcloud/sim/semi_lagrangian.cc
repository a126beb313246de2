// Steps of any length after Stam 1999: each value comes from the start of its trajectory. Transport does not conserve;
// fix_budget() distributes the loss over all cells.
#include "vdbcloud/sim/model.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim {

namespace {

/// The eight points around a position, with their weights; fewer along flat axes.
struct Support {
    ptrdiff_t offset = 0, step[3];
    double weight[3][2];
};

/// Of a position in index space of a field whose first point is (0, 0, 0). Positions beyond the halo are wrapped or
/// clamped.
Support support(const Lattice& l, const ptrdiff_t (&stride)[3], const std::array<double, 3>& x)
{
    Support s;
    for (const size_t d : {0, 1, 2}) {
        const int n = l.n[d];
        s.step[d] = stride[d];
        if (l.flat(int(d))) {
            s.weight[d][0] = 1, s.weight[d][1] = 0, s.step[d] = 0;
            continue;
        }
        double at = x[d];
        if (d < 2 && l.side[d] == Side::Periodic) at -= n * std::floor(at / n);
        at = std::clamp(at, -1.0, double(n));  // also after wrapping: at 1e20 cells a double has no fraction
        const double floor_at = std::min(std::floor(at), double(n - 1));
        s.weight[d][1] = at - floor_at, s.weight[d][0] = 1 - s.weight[d][1];
        s.offset += ptrdiff_t(floor_at) * s.step[d];
    }
    return s;
}

/// Calls f(weight, value) for the points around a position.
template<typename T, typename F>
void visit(const Field<T>& field, const Lattice& l, const std::array<double, 3>& x, const F& f)
{
    const Support s = support(l, {field.stride(0), field.stride(1), field.stride(2)}, x);
    const T* base = field.row(0, 0) + s.offset;
    for (const int c : {0, 1})
        for (const int b : {0, 1})
            for (const int a : {0, 1}) {
                const double w = s.weight[0][a] * s.weight[1][b] * s.weight[2][c];
                if (w != 0) f(w, double(base[a * s.step[0] + b * s.step[1] + c * s.step[2]]));
            }
}

/// Trilinear value at a position.
template<typename T>
double sample(const Field<T>& f, const Lattice& l, const std::array<double, 3>& x)
{
    double sum = 0;
    visit(f, l, x, [&](double weight, double value) { sum += weight * value; });
    return sum;
}

}  // namespace

/// Forces act implicitly where stratification is stable, w <- (w + dt B) / (1 + dt^2 N^2), so that no wave can grow;
/// unstable air still accelerates, and transport keeps all values within the bounds of the old ones.
template<typename T>
void Model<T>::huge_buoyancy(double dt)
{
    const auto [nx, ny, nz] = air_.lattice.n;
    find_buoyancy(0);
    Field<T>& w = air_.wind[2].a[0];
    const double g = parameters_.constants.g / parameters_.constants.theta0;
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = std::max(1, k0); k < k1; ++k)
            for (int j = 0; j < ny; ++j) {
                const T *above = pressure_->scratch().row(j, k), *below = pressure_->scratch().row(j, k - 1);
                for (int i = 0; i < nx; ++i) {
                    const double n2 = g * (double(air_.theta.a[0](i, j, k)) - double(air_.theta.a[0](i, j, k - 1))) /
                                      air_.lattice.h[2];
                    const double pushed = double(w(i, j, k)) + dt * 0.5 * (double(above[i]) + double(below[i]));
                    w(i, j, k) = T(pushed / (1 + dt * dt * std::max(0.0, n2)));
                }
            }
    });
    project(0);
    finish_state(0);
}

/// Transport of one quantity along trajectories of the midpoint rule, from a[0] to a[1]. MacCormack's correction (Selle
/// et al. 2008): transport forwards and back differs from the old value by twice the error. The result is clamped to
/// the values that were interpolated.
template<typename T>
void Model<T>::huge_transport(Variable<T>& v, double dt)
{
    const std::array<double, 3> shift{v.place == Place::FaceX ? 0.0 : 0.5, v.place == Place::FaceY ? 0.0 : 0.5,
                                      v.place == Place::FaceZ ? 0.0 : 0.5};
    const int width = air_.width(v), rows = air_.rows(v);
    const auto velocity_at = [&](const std::array<double, 3>& x, int d) {  // x in cells from the box's corner
        if (air_.lattice.flat(d)) return 0.0;
        std::array<double, 3> at{x[0] - 0.5, x[1] - 0.5, x[2] - 0.5};
        at[size_t(d)] += 0.5;
        return sample(air_.wind[size_t(d)].a[0], air_.lattice, at) / air_.lattice.h[size_t(d)];
    };
    /// Where the air at a point is after `time`, less the shift.
    const auto trace = [&](int i, int j, int k, double time) {
        const std::array<double, 3> here{i + shift[0], j + shift[1], k + shift[2]};
        std::array<double, 3> middle = here, end = here;
        for (const int d : {0, 1, 2}) middle[size_t(d)] += 0.5 * time * velocity_at(here, d);
        for (const int d : {0, 1, 2}) end[size_t(d)] += time * velocity_at(middle, d);
        for (const size_t d : {0, 1, 2}) {  // nothing comes through rigid walls
            if (d == 2 || air_.lattice.side[d] == Side::Wall)
                end[d] = std::clamp(end[d], std::min(0.5, shift[d]), air_.lattice.n[d] - std::min(0.5, shift[d]));
            end[d] -= shift[d];
        }
        return end;
    };
    const auto each = [&](const auto& f) {
        for_chunks(air_.lattice.n[2], 1, [&](int k, int) {
            for (int j = 0; j < rows; ++j)
                for (int i = 0; i < width; ++i) f(i, j, k);
        });
    };
    each([&](int i, int j, int k) { v.a[1](i, j, k) = T(sample(v.a[0], air_.lattice, trace(i, j, k, -dt))); });
    if (!parameters_.maccormack) return;
    fill_halo(air_.lattice, v.place, v.a[1]);
    each([&](int i, int j, int k) {
        const double back = sample(v.a[1], air_.lattice, trace(i, j, k, dt));
        const double corrected = double(v.a[1](i, j, k)) + 0.5 * (double(v.a[0](i, j, k)) - back);
        double low = never, high = -never;
        visit(v.a[0], air_.lattice, trace(i, j, k, -dt),
              [&](double, double value) { low = std::min(low, value), high = std::max(high, value); });
        v.a[2](i, j, k) = T(std::clamp(corrected, low, high));
    });
    v.a[1].swap(v.a[2]);
}

/// Adds friction, relaxation and sources to a[1]. Friction and relaxation are exact factors. Diffusion faster than
/// 1 / dt acts at the rate 1 / dt, so that it reaches its target and does not overshoot.
template<typename T>
void Model<T>::huge_sources(Variable<T>& v, double dt)
{
    const bool scalar = v.place == Place::Centre;
    const Relaxation& relaxation = v.relaxation;
    const Drag drag = scalar ? Drag{never, 0} : air_.drag(int(v.quantity));
    const double least = -air_.reference(v.quantity);
    if (drag.time == never && relaxation.none() && !v.has_sources()) return;
    const T tame = T(std::min(1.0, 1 / std::max(1e-30, dt * air_.fastest_rate)));
    const int width = air_.width(v), rows = air_.rows(v);
    std::vector<double> gained(size_t(air_.lattice.n[2]), 0.0);
    for_chunks(air_.lattice.n[2], 1, [&](int k, int) {
        std::vector<T> source(static_cast<size_t>(width));
        for (int j = 0; j < rows; ++j) {
            std::fill(source.begin(), source.end(), T(0));
            for (const auto& term : v.stiff) term(0, j, k, source.data());
            for (T& rate : source) rate *= tame;
            v.add_sources(0, j, k, source.data());
            for (const auto& sink : v.sinks) sink(0, j, k, source.data());
            T* out = v.a[1].row(j, k);
            for (int i = 0; i < width; ++i) {
                const double was = double(out[i]), pushed = dt * double(source[size_t(i)]);
                const double rate =
                    relaxation.level_rate(k) + relaxation.column_rate(size_t(j) * size_t(width) + size_t(i));
                const double decay = -dt / drag.time - dt * rate;
                const double rest = rest_of(rate, relaxation.none() ? 0 : relaxation.environment[size_t(k)], drag);
                const double value = std::exp(decay) * was - std::expm1(decay) * rest + pushed;
                out[i] = T(scalar && v.quantity != Quantity::Theta ? std::max(least, value) : value);
                gained[size_t(k)] += (scalar ? value - was : pushed) * air_.rho.centre[size_t(k)];
            }
            if (!v.holds.empty()) gained[size_t(k)] += hold(v, dt, j, k, out, width) * air_.rho.centre[size_t(k)];
        }
    });
    for (const double sum : gained) v.sources += sum, v.turnover += std::abs(sum);
    if (relaxation.mean > 0) huge_relaxation(v, dt);
}

/// Relaxes the means of the levels of a[1].
template<typename T>
void Model<T>::huge_relaxation(Variable<T>& v, double dt)
{
    const std::vector<double> means = level_means(air_.lattice, v.a[1]);
    for (int k = 0; k < air_.lattice.n[2]; ++k) {
        const double away = v.relaxation.environment[size_t(k)] - means[size_t(k)];
        const T shift = T(-std::expm1(-dt * v.relaxation.mean) * away);
        for (int j = 0; j < air_.rows(v); ++j)
            for (int i = 0; i < air_.width(v); ++i) v.a[1](i, j, k) += shift;
    }
}

/// Restores the budget of transport: a shift of theta_l in all cells; a factor for water and dye, which keeps them from
/// becoming negative.
template<typename T>
void Model<T>::fix_budget(Variable<T>& v)
{
    double cells = 0;
    for (const double rho : air_.rho.centre) cells += rho * air_.lattice.n[0] * air_.lattice.n[1];
    const double from = air_.reference(v.quantity), mean = extent(v).mean, wanted = v.start.mean + v.sources / cells;
    const bool heat = v.quantity == Quantity::Theta;
    if (!heat && !(mean + from > 0)) return;
    const double factor = heat ? 1 : std::max(0.0, (wanted + from) / (mean + from));
    const double add = heat ? wanted - mean : (factor - 1) * from;
    for_chunks(air_.lattice.n[2], plane_grain(air_.lattice.n[2]), [&](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < air_.lattice.n[1]; ++j) {
                T* row = v.a[0].row(j, k);
                for (int i = 0; i < air_.lattice.n[0]; ++i) row[i] = T(factor * double(row[i]) + add);
            }
    });
    if (v.quantity == Quantity::Water) water_corrected_ += std::abs(wanted - mean) / std::max(1e-12, wanted + from);
}

/// Forces, then transport, then friction and sources, then the projection.
template<typename T>
void Model<T>::huge_step(double dt)
{
    const Parameters& p = parameters_;
    if (p.momentum && p.buoyancy) huge_buoyancy(dt);
    air_.stage_time = air_.time;
    for (const auto& prepare : air_.before_stage) prepare(0);
    std::vector<Variable<T>*> moved = air_.scalars();
    if (p.momentum)
        for (Variable<T>* v : air_.velocities()) moved.push_back(v);
    for (Variable<T>* v : moved) huge_transport(*v, dt), huge_sources(*v, dt);
    for (Variable<T>* v : moved) v->a[0].swap(v->a[1]);
    if (p.fix_budget)
        for (Variable<T>* v : {&air_.theta, &air_.water, &air_.dye})
            if (*v) fix_budget(*v);
    finish_stage(0);
    apply_after_step(dt);
}

template void Model<float>::huge_step(double);
template void Model<double>::huge_step(double);

}  // namespace vdbcloud::sim
