// Budgets of a model, and the first invariant out of its tolerance.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/model.h"
#include "vdbcloud/sim/statistics.h"

#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

template<typename T>
void Model<T>::name_bad_cell() const
{
    const auto [nx, ny, nz] = air_.lattice.n;
    const char* names[] = {"u", "v", "w", "theta_l", "q_t", "rain", "dye", "fuel"};
    for (const Quantity q : {Quantity::Theta, Quantity::Water, Quantity::Rain, Quantity::Dye, Quantity::Fuel,
                             Quantity::U, Quantity::V, Quantity::W}) {
        const Variable<T>& v = air_.of(q);
        for (const Field<T>& f : v.a)
            if (f)
                for (int k = 0; k < nz; ++k)
                    for (int j = 0; j < ny; ++j)
                        for (int i = 0; i < nx; ++i) {
                            if (std::isfinite(f(i, j, k))) continue;
                            std::ostringstream text;
                            text << names[int(q)] << " at cell [" << i << ", " << j << ", " << k << "] = " << f(i, j, k)
                                 << " after " << air_.time << " s: expected a finite number";
                            throw ConvergenceError(text.str());
                        }
    }
    throw ConvergenceError("velocity after " + std::to_string(air_.time) + " s: expected finite numbers");
}

/// Mean and bounds, less the reference. Throws ConvergenceError naming a cell that is not finite.
template<typename T>
Extent Model<T>::extent(const Variable<T>& v) const
{
    const auto [nx, ny, nz] = air_.lattice.n;
    double mass = 0;
    for (int k = 0; k < nz; ++k) mass += air_.rho.centre[size_t(k)] * nx * ny;
    const Extent sums = reduce_planes(
        nz, Extent{},
        [&, nx = nx, ny = ny](int k) {
            Extent e;
            for (int j = 0; j < ny; ++j) {
                const T* row = v.a[0].row(j, k);
                double sum = 0;
                for (int i = 0; i < nx; ++i) {
                    sum += double(row[i]);
                    e.low = std::min(e.low, double(row[i])), e.high = std::max(e.high, double(row[i]));
                }
                e.mean += sum * air_.rho.centre[size_t(k)] / mass;
            }
            return e;
        },
        [](const Extent& a, const Extent& c) {
            return Extent{a.mean + c.mean, std::min(a.low, c.low), std::max(a.high, c.high)};
        });
    if (!std::isfinite(sums.mean)) name_bad_cell();
    return sums;
}

/// Extremes of the air and of the cloud.
template<typename T>
void Model<T>::find_weather(Budget& b) const
{
    const auto [nx, ny, nz] = air_.lattice.n;
    std::vector<double> speed(static_cast<size_t>(nz), 0.0), rise = speed, energy = speed, most = speed, sum = speed;
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        std::vector<T> cloud(size_t(nx), T(0));
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < ny; ++j) {
                for (int c = 0; c < 3; ++c) {
                    if (!air_.wind[size_t(c)]) continue;
                    const T* row = air_.wind[size_t(c)].a[0].row(j, k);
                    const double box = air_.reference(air_.wind[size_t(c)].quantity);
                    double fast = 0, squares = 0;
                    for (int i = 0; i < nx; ++i) {
                        const double over_ground = double(row[i]) + box;
                        fast = std::max(fast, std::abs(over_ground));
                        squares += over_ground * over_ground;
                    }
                    speed[size_t(k)] = std::max(speed[size_t(k)], fast);
                    if (c == 2)
                        for (int i = 0; i < nx; ++i) rise[size_t(k)] = std::max(rise[size_t(k)], double(row[i]));
                    energy[size_t(k)] += 0.5 * squares;
                }
                if (!air_.water) continue;
                thermo_.cloud_row(column_.level[size_t(k)], air_.theta.a[0].row(j, k), air_.water.a[0].row(j, k),
                                  cloud.data(), nx);
                for (int i = 0; i < nx; ++i) {
                    most[size_t(k)] = std::max(most[size_t(k)], double(cloud[size_t(i)]));
                    sum[size_t(k)] += double(cloud[size_t(i)]);
                }
            }
    });
    double mass = 0;
    for (int k = 0; k < nz; ++k) mass += air_.rho.centre[size_t(k)] * nx * ny;
    for (int k = 0; k < nz; ++k) {
        b.speed_max = std::max(b.speed_max, speed[size_t(k)]), b.w_max = std::max(b.w_max, rise[size_t(k)]);
        b.kinetic += energy[size_t(k)] * air_.rho.centre[size_t(k)] / mass;
        b.cloud_max = std::max(b.cloud_max, most[size_t(k)]),
        b.cloud_mean += sum[size_t(k)] * air_.rho.centre[size_t(k)] / mass;
        if (most[size_t(k)] <= cloudy) continue;
        b.cloud_top = column_.level[size_t(k)].z;
        if (b.cloud_base < 0) b.cloud_base = b.cloud_top;
    }
}

/// The first invariant out of its tolerance, or nothing. Tolerances are round-off, in float growing with the steps.
template<typename T>
std::string Model<T>::fault_in(const Budget& b) const
{
    if (!started_ || parameters_.time_scheme == TimeScheme::HugeStep) return "";
    const bool single = sizeof(T) == 4;
    const double thousands = std::max(1.0, double(steps_) / 1000);
    const double drift = single ? std::max(2e-5, 2e-6 * thousands) : 1e-12 * std::max(1.0, thousands);
    // The pressure scales with the longest side, its differences with a spacing: their ratio is lost, in ulps: two of
    // them.
    double longest = 0, shortest = never;
    for (const size_t d : {0, 1, 2}) {
        longest = std::max(longest, air_.lattice.n[d] * air_.lattice.h[d]);
        if (!air_.lattice.flat(int(d))) shortest = std::min(shortest, air_.lattice.h[d]);
    }
    const double still = std::max(single ? 1e-5 : 1e-12, (single ? 2.4e-7 : 4.5e-16) * longest / shortest);
    std::ostringstream fault;
    if (std::abs(b.water_drift) > drift)
        fault << "drift of total water " << b.water_drift << ", tolerance " << drift;
    else if (std::abs(b.theta_drift) > drift)
        fault << "drift of theta_l " << b.theta_drift << ", tolerance " << drift;
    else if (b.divergence > still)
        fault << "divergence " << b.divergence << ", tolerance " << still;
    else if (b.water_min < 0)
        fault << "total water " << b.water_min << " kg/kg, below 0";
    return fault.str();
}

template<typename T>
Budget Model<T>::budget() const
{
    Budget b;
    b.time = air_.time, b.steps = steps_, b.retries = retries_, b.dt = air_.dt, b.rain_fallen = air_.rain_fallen;
    b.water_corrected = water_corrected_;
    double cells = 0, grown = 0;
    for (const double rho : air_.rho.centre) cells += rho * air_.lattice.n[0] * air_.lattice.n[1];
    bool sourced = false;
    const auto account = [&](const Variable<T>& v, double& mean, double& drift, double& low, double& high,
                             bool of_range) {
        const Extent e = extent(v);
        const double shift = air_.reference(v.quantity), gained = v.sources / cells;
        mean = e.mean + shift, low = e.low + shift, high = e.high + shift;
        if (!started_) return;
        const double range = v.start.high - v.start.low;
        // Relative to the range, or to what sources brought; rounding of the values bounds what a small range resolves.
        const double size = std::max(std::abs(e.low), std::abs(e.high));
        const double unit = of_range ? std::max({range, e.high - e.low, std::abs(gained), 0.05 * size, 1e-3})
                                     : std::max({v.start.mean + shift, std::abs(gained), 1e-12});
        drift = (e.mean - v.start.mean - gained) / unit;
        sourced = sourced || !v.row_source.empty();
        grown = std::max(grown, std::max(e.high - v.start.high, v.start.low - e.low) /
                                    std::max(range, of_range ? 1e-3 : 1e-9));
    };
    const auto account_tracer = [&](const Variable<T>& v, double& mean, double& drift) {
        mean = extent(v).mean;
        if (started_)
            drift = (mean - v.start.mean - v.sources / cells) / std::max({v.start.mean, v.turnover / cells, 1e-12});
    };
    if (air_.dye) account_tracer(air_.dye, b.dye_mean, b.dye_drift);
    if (air_.fuel) account_tracer(air_.fuel, b.fuel_mean, b.fuel_drift);
    if (air_.theta) account(air_.theta, b.theta_mean, b.theta_drift, b.theta_min, b.theta_max, true);
    if (air_.water) account(air_.water, b.water_mean, b.water_drift, b.water_min, b.water_max, false);
    b.new_extrema = sourced || !air_.after_step.empty() ? -1 : std::max(0.0, grown);
    find_weather(b);
    b.courant = air_.dt * rate_;
    if (pressure_) {
        double h = never;
        for (const int d : {0, 1, 2})
            if (!air_.lattice.flat(d)) h = std::min(h, air_.lattice.h[size_t(d)]);
        b.divergence = pressure_->max_divergence(air_.carrier(0, 0), air_.carrier(1, 0), air_.carrier(2, 0)) * h /
                       std::max(b.speed_max, windiest());
    }
    b.fault = fault_in(b);
    return b;
}

/// The largest wind of the environment, which relaxation may push against walls, where the pressure stops it; at least
/// 0.1 m/s, as air at rest has round-off only.
template<typename T>
double Model<T>::windiest() const
{
    double most = 0.1;
    for (size_t k = 0; k < column_.u.size(); ++k)
        most = std::max({most, std::abs(column_.u[k]), std::abs(column_.v[k])});
    return most;
}

#define VDBCLOUD_BUDGET(T)                                                                                             \
    template void Model<T>::name_bad_cell() const;                                                                     \
    template Extent Model<T>::extent(const Variable<T>&) const;                                                        \
    template double Model<T>::windiest() const;                                                                        \
    template Budget Model<T>::budget() const;
VDBCLOUD_BUDGET(float)
VDBCLOUD_BUDGET(double)
#undef VDBCLOUD_BUDGET

}  // namespace vdbcloud::sim
