#include "vdbcloud/sim/model.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud::sim {

Simulation::Simulation(const Parameters& p, const Sounding& s)
    : parameters_((check(p, s), p)), column_(make_column(p, s)),
      thermo_(p.constants, p.moist, p.moisture, column_.reference)
{
}
Simulation::~Simulation() = default;

std::unique_ptr<Simulation> Simulation::make(const Parameters& p, const Sounding& s)
{
    if (p.precision == Precision::Double) return std::make_unique<Model<double>>(p, s);
    return std::make_unique<Model<float>>(p, s);
}

template<typename T>
Model<T>::Model(const Parameters& p, const Sounding& s) : Simulation(p, s), air_(parameters_, column_, thermo_)
{
    drain_ = Field<T>(air_.lattice);
    if (p.momentum) pressure_.emplace(air_.lattice, air_.rho);
    if (air_.bodies) obstacles_.emplace(air_.lattice, air_.rho, *pressure_, air_.bodies);
    set_initial_air();
}

/// Fills the halos of the arrays `at`.
template<typename T>
void Model<T>::finish_state(int at)
{
    for (Variable<T>* v : air_.velocities()) fill_halo(air_.lattice, v->place, v->a[air_.wind_at(at)]);
    finish_scalars(at, true);
}

/// Fills the halos of scalars; `rows`: at the ends of rows, too. Beyond open sides, scalars are the environment's where
/// the wind blows inwards.
template<typename T>
void Model<T>::finish_scalars(int at, bool rows)
{
    const Continuation<T> beyond(air_.lattice, Place::Centre);
    for (Variable<T>* v : air_.scalars()) {
        Field<T>& f = v->a[size_t(at)];
        for_chunks(air_.lattice.n[2], plane_grain(air_.lattice.n[2]), [&](int k0, int k1) {
            for (int k = k0; k < k1; ++k) rows ? beyond.rows(f, k) : beyond.plane(f, k);
        });
        beyond.below_and_above(f);
        if (air_.lattice.side[0] != Side::Open && air_.lattice.side[1] != Side::Open) continue;
        const auto [nx, ny, nz] = air_.lattice.n;
        for (int k = 0; k < nz; ++k) {
            const Level& level = column_.level[size_t(k)];
            const T env = T(v->quantity == Quantity::Theta   ? level.theta_env
                            : v->quantity == Quantity::Water ? level.q_env
                                                             : 0);
            if (air_.lattice.side[0] == Side::Open && air_.wind[0])
                for (int j = 0; j < ny; ++j) {
                    const Field<T>& u = air_.wind[0].a[air_.wind_at(at)];
                    for (int m = 1; m <= halo; ++m) {
                        if (u(0, j, k) > 0) f(-m, j, k) = env;
                        if (u(nx, j, k) < 0) f(nx - 1 + m, j, k) = env;
                    }
                }
            if (air_.lattice.side[1] == Side::Open && air_.wind[1])
                for (int i = 0; i < nx; ++i) {
                    const Field<T>& w = air_.wind[1].a[air_.wind_at(at)];
                    for (int m = 1; m <= halo; ++m) {
                        if (w(i, 0, k) > 0) f(i, -m, k) = env;
                        if (w(i, ny, k) < 0) f(i, ny - 1 + m, k) = env;
                    }
                }
        }
    }
}

template<typename T>
void Model<T>::take_courant(int at)
{
    const auto [nx, ny, nz] = air_.lattice.n;
    const Field<T>&u = air_.carrier(0, at), &v = air_.carrier(1, at), &w = air_.carrier(2, at);
    std::vector<double> rate(size_t(nz), 0.0);
    const Continuation<T> beyond(air_.lattice, Place::Centre, 1);  // fluxes read one cell beside their row
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            const double z0 = air_.rho.face[size_t(k)] / air_.rho.centre[size_t(k)] / air_.lattice.h[2];
            const double z1 = air_.rho.face[size_t(k) + 1] / air_.rho.centre[size_t(k)] / air_.lattice.h[2];
            double top = 0;
            for (int j = 0; j < ny && std::isfinite(top); ++j)
                courant(CourantRows<T>{u ? u.row(j, k) : nullptr, v ? v.row(j, k) : nullptr,
                                       v ? v.row(j + 1, k) : nullptr, air_.lattice.flat(2) ? nullptr : w.row(j, k),
                                       air_.lattice.flat(2) ? nullptr : w.row(j, k + 1), T(1 / air_.lattice.h[0]),
                                       T(1 / air_.lattice.h[1]), T(z0), T(z1)},
                        drain_.row(j, k), top, nx);
            beyond.rows(drain_, k);
            rate[size_t(k)] = top;
        }
    });
    rate_ = 0;
    for (const double r : rate)
        if (!(r <= rate_)) rate_ = r;
    for (const double r : rate)
        if (!std::isfinite(r)) rate_ = r;
    if (!std::isfinite(rate_)) name_bad_cell();
    beyond.below_and_above(drain_);
}

/// Buoyancy at centres, into the planes that the projection will overwrite.
template<typename T>
void Model<T>::find_buoyancy(int at)
{
    const auto [nx, ny, nz] = air_.lattice.n;
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < ny; ++j)
                thermo_.buoyancy_row(column_.level[size_t(k)], air_.theta.a[size_t(at)].row(j, k),
                                     air_.water ? air_.water.a[size_t(at)].row(j, k) : nullptr,
                                     air_.rain && parameters_.moist.loading ? air_.rain.a[size_t(at)].row(j, k)
                                                                            : nullptr,
                                     pressure_->scratch().row(j, k), nx);
    });
}

template<typename T>
void Model<T>::advance_scalar(Variable<T>& variable, const Stage& stage, double dt)
{
    const size_t in = size_t(stage.in);
    const Field<T>& q = variable.a[in];
    // Rounding takes values near 0 below it by their last bits: the stage raises these to 0.
    const double least = -air_.reference(variable.quantity),
                 ulps = 4 * double(std::numeric_limits<T>::epsilon()) * -least;
    const double tiny = variable.quantity == Quantity::Theta ? 0 : std::max(sizeof(T) == 4 ? 1e-9 : 1e-17, ulps);
    const ScalarStage s{stage.alpha, stage.beta, stage.tau * dt, least, tiny};
    const T inv_tau = T(1 / s.tau);
    const auto [nx, ny, nz] = air_.lattice.n;
    const bool open_x = air_.lattice.side[0] == Side::Open && !air_.lattice.flat(0);
    const bool open_y = air_.lattice.side[1] == Side::Open && !air_.lattice.flat(1);

    const auto flux = [&](int axis, int j, int k, T* out, int n) {
        const ScalarFlux<T> f{air_.carrier(axis, stage.in).row(j, k), q.row(j, k), drain_.row(j, k), inv_tau,
                              q.stride(axis)};
        scalar_flux(parameters_.scalar_scheme, f, out, n);
    };
    const auto coefficients = [&](int k, FluxRows<T>& rows) {
        const double rho = air_.rho.centre[size_t(k)] * air_.lattice.h[2];
        rows.cx = T(1 / air_.lattice.h[0]), rows.cy = T(1 / air_.lattice.h[1]);
        rows.cz0 = T(air_.rho.face[size_t(k)] / rho), rows.cz1 = T(air_.rho.face[size_t(k) + 1] / rho);
    };
    const ColumnFactors factors(variable.relaxation, stage, dt);
    const Continuation<T> beyond(air_.lattice, Place::Centre);
    const bool last = &stage == &stages(parameters_.time_scheme).back();
    const StageWeights plain{1 - s.alpha - s.beta, s.alpha, s.beta, s.beta * s.tau, 0};
    const auto sink = [&, nx = nx, ny = ny](int j, int k, T* tendency, const FluxRows<T>& rows) {
        const StageRows<T> row{variable.a[size_t(stage.out)].row(j, k), variable.a[0].row(j, k),
                               variable.a[size_t(stage.x1)].row(j, k), q.row(j, k), tendency};
        if (!variable.row_source.empty()) {
            T source[4096];
            std::fill_n(source, nx, T(0));
            variable.add_sources(stage.in, j, k, source);
            for (const auto& term : variable.stiff) term(stage.in, j, k, source);
            double sum = 0;
            for (int i = 0; i < nx; ++i) sum += double(source[i]), tendency[i] += source[i];
            if (!variable.sinks.empty()) sum += take_out(variable, stage.in, j, k, {row.x, s.least, s.tau}, tendency);
            if (open_x) sum -= double(rows.cx) * (double(rows.x[nx]) - double(rows.x[0]));
            if (open_y && j == 0)
                for (int i = 0; i < nx; ++i) sum += double(rows.cy) * double(rows.y0[i]);
            if (open_y && j == ny - 1)
                for (int i = 0; i < nx; ++i) sum -= double(rows.cy) * double(rows.y1[i]);
            if (!factors.none())
                sum += add_return(plain, factors, size_t(j) * size_t(nx), row,
                                  variable.relaxation.environment[size_t(k)], tendency, nx);
            variable.row_source[size_t(k) * size_t(ny) + size_t(j)] = sum * air_.rho.centre[size_t(k)];
        }
        scalar_stage(row, s, nx);
        if (last && !variable.holds.empty())
            variable.row_source[size_t(k) * size_t(ny) + size_t(j)] +=
                hold(variable, dt, j, k, row.out, nx) * air_.rho.centre[size_t(k)] / (stage.weight * dt);
        // What leads back to 0 rounds as the fluxes that it outweighs do.
        if (!factors.none() && tiny > 0)
            for (int i = 0; i < nx; ++i)
                if (factors.column[size_t(j) * size_t(nx) + size_t(i)] > 0) row.out[i] = std::max(row.out[i], T(least));
        beyond.row(row.out);
    };
    for_flux_rows<T>({nx, ny, 0, nz, !air_.lattice.flat(0), !air_.lattice.flat(1), !air_.lattice.flat(2)}, coefficients,
                     flux, sink);
    for (const double sum : variable.row_source)
        variable.sources += stage.weight * dt * sum, variable.turnover += stage.weight * dt * std::abs(sum);
}

template<typename T>
void Model<T>::advance_velocity(int axis, const Stage& stage, double dt)
{
    Variable<T>& variable = air_.wind[size_t(axis)];
    const size_t in = size_t(stage.in);
    const Field<T>& q = variable.a[in];
    const Relaxation& relaxation = variable.relaxation;
    const TimedStage timed{stage, stages(parameters_.time_scheme), dt, air_.drag(axis)};
    const ColumnWeights columns(relaxation, timed);
    std::vector<MomentumStage> levels;  // with the integrating factor of friction, and the return to the environment
    for (int k = 0; k < air_.lattice.n[2]; ++k) {
        const double rate = relaxation.level_rate(k), env = relaxation.none() ? 0 : relaxation.environment[size_t(k)];
        const StageWeights w = weights_of(timed, rate);
        levels.push_back({w.x0, w.x1, w.x, w.tendency, w.rest * rest_of(rate, env, timed.drag)});
    }
    LevelMeans means;
    if (relaxation.mean > 0)
        means = {level_means(air_.lattice, variable.a[0]),
                 level_means(air_.lattice, variable.a[size_t(stage.x1)]),
                 level_means(air_.lattice, q),
                 {}};
    const bool vertical = axis == 2, last = &stage == &timed.all.back();

    const auto flux = [&](int d, int j, int k, T* out, int n) {
        const Field<T>& carrier = air_.carrier(d, stage.in);
        const T* b = carrier.row(j, k);
        // Mean of the two mass fluxes beside the edge or centre; weights matter in an anelastic base state only.
        double wa = 0.5, wb = 0.5;
        if (vertical && d != 2) wa *= air_.rho.centre[size_t(k)], wb *= air_.rho.centre[size_t(k) - 1];
        if (vertical && d == 2) wa *= air_.rho.face[size_t(k)], wb *= air_.rho.face[size_t(k) - 1];
        momentum_flux(parameters_.momentum_scheme,
                      {b, b - carrier.stride(axis), T(wa), T(wb), q.row(j, k), q.stride(d)}, out, n);
    };
    const auto coefficients = [&](int k, FluxRows<T>& rows) {
        if (vertical) {
            const double rho = air_.rho.face[size_t(k)];
            rows.cx = T(1 / air_.lattice.h[0] / rho), rows.cy = T(1 / air_.lattice.h[1] / rho);
            rows.cz0 = rows.cz1 = T(1 / air_.lattice.h[2] / rho);
            return;
        }
        const double rho = air_.rho.centre[size_t(k)] * air_.lattice.h[2];
        rows.cx = T(1 / air_.lattice.h[0]), rows.cy = T(1 / air_.lattice.h[1]);
        rows.cz0 = T(air_.rho.face[size_t(k)] / rho), rows.cz1 = T(air_.rho.face[size_t(k) + 1] / rho);
    };
    const int width = axis == 0 ? air_.lattice.faces(0) : air_.lattice.n[0];
    const int rows = axis == 1 ? air_.lattice.faces(1) : air_.lattice.n[1];
    const auto sink = [&](int j, int k, T* tendency, const FluxRows<T>&) {
        if (vertical && parameters_.buoyancy)
            add_sum(tendency, pressure_->scratch().row(j, k), pressure_->scratch().row(j, k - 1), T(0.5), width);
        variable.add_sources(stage.in, j, k, tendency);
        for (const auto& term : variable.stiff) term(stage.in, j, k, tendency);
        const StageRows<T> row{variable.a[size_t(stage.out)].row(j, k), variable.a[0].row(j, k),
                               variable.a[size_t(stage.x1)].row(j, k), q.row(j, k), tendency};
        const MomentumStage& s = levels[size_t(k)];
        T kept[4097];  // `out` may be an input
        if (!columns.none()) columns.row(j, k, row, kept, width);
        momentum_stage(row, s, width);
        if (!columns.none())
            for (int i = 0; i < width; ++i)
                if (columns.acts(size_t(j) * size_t(width) + size_t(i))) row.out[i] = kept[i];
        if (last && !variable.holds.empty()) hold(variable, dt, j, k, row.out, width);
    };
    for_flux_rows<T>({width, rows, vertical ? 1 : 0, air_.lattice.n[2], !air_.lattice.flat(0), !air_.lattice.flat(1),
                      !air_.lattice.flat(2)},
                     coefficients, flux, sink);
    if (relaxation.mean > 0) relax_means(variable, timed, means);
}

/// Shifts the levels that a stage wrote, so that their means relax too. `means`: of x0, x1 and x.
template<typename T>
void Model<T>::relax_means(Variable<T>& v, const TimedStage& timed, LevelMeans& means)
{
    Field<T>& out = v.a[size_t(timed.stage.out)];
    means.out = level_means(air_.lattice, out);
    const std::vector<double> shifts = mean_shifts(v.relaxation, timed, means);
    for (int k = 0; k < air_.lattice.n[2]; ++k)
        for (int j = 0; j < air_.rows(v); ++j)
            for (int i = 0; i < air_.width(v); ++i) out(i, j, k) += T(shifts[size_t(k)]);
}

/// Makes the air in the arrays `at` incompressible and fills its halos.
template<typename T>
void Model<T>::finish_stage(int at)
{
    const bool huge = parameters_.time_scheme == TimeScheme::HugeStep;  // other stages have continued their rows
    if (parameters_.momentum) project(at);
    finish_scalars(at, huge);
    if (parameters_.momentum) take_courant(at);
}

template<typename T>
void Model<T>::project(int at)
{
    const size_t a = size_t(at);
    Field<T>&u = air_.wind[0].a[a], &v = air_.wind[1].a[a], &w = air_.wind[2].a[a];
    obstacles_ ? obstacles_->project(u, v, w, windiest()) : pressure_->project(u, v, w);
}

/// Where bodies are, what carries air through faces follows from the wind in the arrays `at`.
template<typename T>
void Model<T>::find_flux(int at)
{
    const size_t a = size_t(at);
    if (obstacles_) obstacles_->set_flux(air_.wind[0].a[a], air_.wind[1].a[a], air_.wind[2].a[a]);
}

/// Applies the effects that act between steps to the arrays 0.
template<typename T>
void Model<T>::apply_after_step(double dt)
{
    for (const auto& apply : air_.after_step) apply(dt);
    if (!air_.after_step.empty()) finish_state(0);
}

/// Takes one step. Returns false and leaves the state as it was if the air becomes too fast for dt within the step.
template<typename T>
bool Model<T>::step(double dt)
{
    const auto& list = stages(parameters_.time_scheme);
    std::vector<std::array<double, 2>> accounts;
    for (Variable<T>* v : air_.scalars()) accounts.push_back({v->sources, v->turnover});
    for (const Stage& stage : list) {
        if (stage.tau * dt * rate_ > 1) {  // never in the first stage: dt was chosen for it
            size_t i = 0;
            for (Variable<T>* v : air_.scalars()) v->sources = accounts[i][0], v->turnover = accounts[i++][1];
            find_flux(0);
            take_courant(0);
            return false;
        }
        air_.stage_time = air_.time + stage.time_in * dt;
        for (const auto& prepare : air_.before_stage) prepare(stage.in);
        if (parameters_.momentum && parameters_.buoyancy) find_buoyancy(stage.in);
        for (Variable<T>* v : air_.scalars()) advance_scalar(*v, stage, dt);
        if (parameters_.momentum)
            for (int axis = 0; axis < 3; ++axis)
                if (air_.wind[size_t(axis)] && !(axis == 2 && air_.lattice.flat(2))) advance_velocity(axis, stage, dt);
        finish_stage(stage.out);
    }
    if (list.back().out != 0) {
        for (Variable<T>* v : air_.scalars()) v->a[0].swap(v->a[1]);
        if (parameters_.momentum)
            for (Variable<T>* v : air_.velocities()) v->a[0].swap(v->a[1]);
    }
    apply_after_step(dt);
    return true;
}

template<typename T>
void Model<T>::advance_to(double end, const Progress& progress)
{
    if (!started_) start();
    const double begin = air_.time;
    double halving = 1;
    while (air_.time < end) {
        report(progress, (air_.time - begin) / (end - begin));
        // A step ends where the fluxes through the floor do, so that it has them wholly or not at all.
        const bool cut = air_.floor_has_fluxes() && parameters_.floor.until < end - 1e-9 * std::max(1.0, end);
        double stop = cut ? parameters_.floor.until : end;
        const double just = 1e-9 * std::max(1.0, end);
        for (const double edge : air_.step_ends)
            if (edge > air_.time + just && edge < stop - just) stop = edge;
        const double left = stop - air_.time;
        if (parameters_.time_scheme == TimeScheme::HugeStep) {
            const double asked = parameters_.dt > 0 ? parameters_.dt : left;
            const double count = std::max(1.0, std::ceil(left / asked - 1e-9));
            air_.dt = left / count;
            huge_step(air_.dt);
            air_.time = count <= 1 ? stop : air_.time + air_.dt;
            ++steps_;
            continue;
        }
        // The wanted step is split into equal parts within the limits; the last part ends at `stop`.
        const double asked = parameters_.dt > 0 ? std::min(parameters_.dt, left) : left;
        const double whole = std::max(1.0, std::ceil(left / asked - 1e-9));
        const double parts = std::max(1.0, std::ceil(left / whole / (step_limit() * halving) - 1e-9));
        air_.dt = left / (whole * parts);
        if (!(air_.dt > 1e-9 * std::max(1.0, air_.time)))
            throw ConvergenceError("time step after " + std::to_string(air_.time) +
                                   " s: expected above 1e-9 of the time");
        if (!step(air_.dt)) {
            halving *= 0.5;
            ++retries_;
            continue;
        }
        halving = 1;
        air_.time = whole * parts <= 1 ? stop : air_.time + air_.dt;
        ++steps_;
    }
}

template class Model<float>;
template class Model<double>;

}  // namespace vdbcloud::sim
