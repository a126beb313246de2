#include "vdbcloud/sim/relaxation.h"

#include "vdbcloud/sim/parallel.h"
#include "vdbcloud/sim/stages.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim {

namespace {

/// A rate in parts: `stiff` acts as an integrating factor, `mild` as a tendency.
struct Split {
    double stiff, mild;
};

/// A number and its derivative.
struct Dual {
    double value, slope;
};

/// What the stages of a step make of 1 under dq/dt = -z q, where z is in units of 1 / dt, and its derivative by z.
Dual decayed(const std::vector<Stage>& stages, double z)
{
    std::array<Dual, 4> q;
    q.fill({1, 0});
    const Dual first = q[0];
    for (const Stage& s : stages) {
        const Dual x1 = q[size_t(s.x1)], x = q[size_t(s.in)];
        const double kept = 1 - s.alpha - s.beta, damped = s.beta * (1 - s.tau * z);
        q[size_t(s.out)] = {kept * first.value + s.alpha * x1.value + damped * x.value,
                            kept * first.slope + s.alpha * x1.slope + damped * x.slope - s.beta * s.tau * x.value};
    }
    return q[size_t(stages.back().out)];
}

/// z = mild dt makes the factor of the stages exp(-x), x = rate dt up to 0.5.
Split split_of(double rate, double dt, const std::vector<Stage>& stages)
{
    const double x = std::min(0.5, rate * dt), wanted = std::exp(-x);
    double z = x;
    for (int newton = 0; newton < 6; ++newton) {
        const Dual factor = decayed(stages, z);
        z -= (factor.value - wanted) / factor.slope;
    }
    return {std::max(0.0, rate - x / dt), z / dt};
}

}  // namespace

double rest_of(double rate, double environment, const Drag& drag)
{
    const double share = rate > 0 ? rate / (rate + 1 / drag.time) : 0;
    const double rest = rate > 0 ? environment * share : 0;
    return drag.ground != 0 && std::isfinite(drag.time) ? rest + drag.ground * (1 - share) : rest;
}

StageWeights weights_of(const TimedStage& timed, double rate)
{
    const Stage& s = timed.stage;
    const Split split = rate > 0 ? split_of(rate, timed.dt, timed.all) : Split{0, 0};
    const auto exponent = [&](double from) {
        const double time = (s.time_out - from) * timed.dt;
        return -time / timed.drag.time - time * split.stiff;
    };
    const double c0 = 1 - s.alpha - s.beta, e0 = exponent(0), e1 = exponent(s.time_x1), ex = exponent(s.time_in);
    const double fx = std::exp(ex), tendency = s.beta * s.tau * timed.dt * fx;
    const double rest = -(c0 * std::expm1(e0) + s.alpha * std::expm1(e1) + s.beta * std::expm1(ex));
    return {c0 * std::exp(e0), s.alpha * std::exp(e1), s.beta * fx - tendency * split.mild, tendency,
            rest + tendency * split.mild};
}

void Relaxation::set_columns(const std::vector<double>& each)
{
    rates = each;
    rates.push_back(0);
    std::sort(rates.begin(), rates.end());
    rates.erase(std::unique(rates.begin(), rates.end()), rates.end());
    column.clear();
    for (const double rate : each)
        column.push_back(uint16_t(std::lower_bound(rates.begin(), rates.end(), rate) - rates.begin()));
}

ColumnFactors::ColumnFactors(const Relaxation& relaxation, const Stage& stage, double dt) : column(relaxation.column)
{
    const auto factors = [&](double from) {
        std::vector<double> list;
        for (const double rate : relaxation.rates) list.push_back(std::exp(-(stage.time_out - from) * dt * rate));
        return list;
    };
    x0 = factors(0), x1 = factors(stage.time_x1), x = factors(stage.time_in);
}

template<typename T>
double add_return(const StageWeights& plain, const ColumnFactors& factors, size_t first, const StageRows<T>& r,
                  double environment, T* tendency, int n)
{
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const size_t index = factors.column[first + size_t(i)];
        if (index == 0) continue;
        const double e0 = factors.x0[index], e1 = factors.x1[index], ex = factors.x[index];
        const double rest = 1 - (plain.x0 * e0 + plain.x1 * e1 + plain.x * ex);
        const double base = double(r.x0[i]), rate = double(tendency[i]);
        const double change = plain.x1 * (e1 - 1) * (double(r.x1[i]) - base) +
                              (ex - 1) * (plain.x * (double(r.x[i]) - base) + plain.tendency * rate) +
                              rest * (environment - base);
        tendency[i] = T(rate + change / plain.tendency);
        sum += change / plain.tendency;
    }
    return sum;
}

ColumnWeights::ColumnWeights(const Relaxation& relaxation, const TimedStage& stage)
    : column_(relaxation.column), rates_(relaxation.rates.size())
{
    if (none()) return;
    for (size_t k = 0; k < relaxation.environment.size(); ++k)
        for (const double column : relaxation.rates) {
            const double rate = relaxation.level_rate(int(k)) + column;
            StageWeights w = weights_of(stage, rate);
            w.rest *= rest_of(rate, relaxation.environment[k], stage.drag);
            weights_.push_back(w);
        }
}

template<typename T>
void ColumnWeights::row(int j, int k, const StageRows<T>& r, T* out, int width) const
{
    const uint16_t* column = &column_[size_t(j) * size_t(width)];
    const StageWeights* weights = &weights_[size_t(k) * rates_];
    for (int i = 0; i < width; ++i)
        if (column[i] > 0)
            out[i] =
                T(weights[column[i]].value(double(r.x0[i]), double(r.x1[i]), double(r.x[i]), double(r.tendency[i]), 1));
}

template<typename T>
std::vector<double> level_means(const Lattice& lattice, const Field<T>& field)
{
    const auto [nx, ny, nz] = lattice.n;
    std::vector<double> means(static_cast<size_t>(nz), 0.0);
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            double sum = 0;
            for (int j = 0; j < ny; ++j) {
                const T* row = field.row(j, k);
                for (int i = 0; i < nx; ++i) sum += double(row[i]);
            }
            means[size_t(k)] = sum / (double(nx) * ny);
        }
    });
    return means;
}

std::vector<double> mean_shifts(const Relaxation& r, const TimedStage& timed, const LevelMeans& means)
{
    std::vector<double> shifts;
    for (size_t k = 0; k < means.out.size(); ++k) {
        const double level = r.level_rate(int(k)), both = level + r.mean, env = r.environment[k];
        const auto combined = [&](double rate, double tendency) {
            return weights_of(timed, rate)
                .value(means.x0[k], means.x1[k], means.x[k], tendency, rest_of(rate, env, timed.drag));
        };
        // The mean of the tendency follows from what the stage wrote, in double: relax_means() has no other.
        const double push = weights_of(timed, level).tendency;
        const double tendency = push > 1e-200 ? (means.out[k] - combined(level, 0)) / push : 0;
        shifts.push_back(combined(both, tendency) - means.out[k]);
    }
    return shifts;
}

#define VDBCLOUD_RELAXATION(T)                                                                                         \
    template std::vector<double> level_means(const Lattice&, const Field<T>&);                                         \
    template double add_return(const StageWeights&, const ColumnFactors&, size_t, const StageRows<T>&, double, T*,     \
                               int);                                                                                   \
    template void ColumnWeights::row(int, int, const StageRows<T>&, T*, int) const;
VDBCLOUD_RELAXATION(float)
VDBCLOUD_RELAXATION(double)
#undef VDBCLOUD_RELAXATION

}  // namespace vdbcloud::sim
