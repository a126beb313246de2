// Warm rain after Kessler 1969, in the form of Klemp and Wilhelmson 1978, column by column between steps. rho is the
// density of the base state in g/cm^3, p its pressure in Pa:
//
//     autoconversion   1e-3 (q_c - 1e-3)                                                       [1/s]
//     accretion        2.2 q_c q_r^0.875                                                       [1/s]
//     evaporation      (1 - q_t/q_s) (1.6 + 124.9 (rho q_r)^0.2046) (rho q_r)^0.525
//                      / ((5.4e5 + 2.55e8 / (p q_s)) rho)                                      [1/s]
//     with a number N of droplets in a cm^3, after Khairoutdinov and Kogan 2000, in place of the first two:
//     autoconversion   1350 q_c^2.47 N^-1.79                                                   [1/s]
//     accretion        67 (q_c q_r)^1.15                                                       [1/s]
//     fall speed       36.34 (rho q_r)^0.1346 sqrt(rho_floor / rho)                            [m/s]
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// What a column of cells gave: sums over cells, weighted with the density of the base state.
struct Exchange {
    double warmed = 0;  ///< of theta_l [K]
    double wetted = 0;  ///< of q_t [kg/kg]
    double fallen = 0;  ///< onto the floor [kg/kg of the lowest cell]
};

/// Water that cloud of so many droplets in a cm^3 gives to rain within dt [kg/kg], at most the cloud. 0: Kessler's
/// rates.
double converted(double q_c, double q_r, double droplets, double dt)
{
    const double rate = droplets > 0
                            ? 1350 * std::pow(q_c, 2.47) * std::pow(droplets, -1.79) + 67 * std::pow(q_c * q_r, 1.15)
                            : 1e-3 * std::max(0.0, q_c - 1e-3) + 2.2 * q_c * std::pow(q_r, 0.875);
    return std::min(dt * rate, q_c);
}

/// Rain that evaporates within dt [kg/kg]: not more than there is, nor so much that the cooled air would be above
/// saturation.
double evaporated(double q_t, double q_s, double q_r, double rho, double pressure, double dt)
{
    const double dry = 1 - q_t / q_s;
    const double vent = 1.6 + 124.9 * std::pow(rho * q_r, 0.2046);
    const double rate = dry * vent * std::pow(rho * q_r, 0.525) / ((5.4e5 + 2.55e8 / (pressure * q_s)) * rho);
    return std::min({dt * std::max(0.0, rate), q_r, 0.25 * std::max(0.0, q_s - q_t)});
}

/// Exchange between cloud, vapour and rain in one row of cells. theta_l counts only cloud water: cloud that becomes
/// rain leaves its heat, evaporation takes it back.
template<typename T>
void exchange_row(Air<T>& air, int j, int k, double dt, std::vector<T>& cloud, Exchange& sum)
{
    const Constants& c = air.parameters.constants;
    const Level& level = air.column.level[size_t(k)];
    const Reference& reference = air.column.reference;
    T *theta = air.theta.a[0].row(j, k), *water = air.water.a[0].row(j, k), *drops = air.rain.a[0].row(j, k);
    air.thermo.cloud_row(level, theta, water, cloud.data(), air.lattice.n[0]);
    const double warm = air.parameters.moist.latent_heat ? level.heat : 0, mass = air.rho.centre[size_t(k)];
    for (int i = 0; i < air.lattice.n[0]; ++i) {
        const double q_c = double(cloud[size_t(i)]), q_r = std::max(0.0, double(drops[i]));
        if (q_c <= 0 && q_r <= 0) continue;
        double change = 0;
        if (q_c > 0) {
            change = converted(q_c, q_r, air.parameters.droplets, dt);
        } else {
            const double t = (double(theta[i]) + reference.theta) * level.exner;
            const double q_s = air.parameters.moist.by == SaturationBy::Height
                                   ? level.q_height
                                   : air.thermo.saturation(t, level.pressure);
            const double q_t = double(water[i]) + reference.water;
            change = -evaporated(q_t, q_s, q_r, 1e-3 * c.rho0 * mass, level.pressure, dt);
        }
        const T q_left = T(double(water[i]) - change), q_rain = T(q_r + change),
                t_l = T(double(theta[i]) + warm * change);
        sum.warmed += (double(t_l) - double(theta[i])) * mass;
        sum.wetted += (double(q_left) - double(water[i])) * mass;
        water[i] = q_left, drops[i] = q_rain, theta[i] = t_l;
    }
}

/// Rain of one column falls for dt, upwind, in sub-steps of its own Courant number. `q` and `speed` are scratch, a
/// value a level.
template<typename T>
void fall(Air<T>& air, int i, int j, double dt, std::vector<double>& q, std::vector<double>& speed, Exchange& sum)
{
    const int nz = air.lattice.n[2];
    const double dz = air.lattice.h[2], rho0 = air.parameters.constants.rho0;
    Field<T>& rain = air.rain.a[0];
    const auto find_speed = [&] {
        double fastest = 0;
        for (int k = 0; k < nz; ++k) {
            const double rho = air.rho.centre[size_t(k)];
            speed[size_t(k)] = 36.34 * std::pow(1e-3 * rho0 * rho * q[size_t(k)], 0.1346) / std::sqrt(rho);
            fastest = std::max(fastest, speed[size_t(k)]);
        }
        return fastest;
    };
    for (int k = 0; k < nz; ++k) q[size_t(k)] = std::max(0.0, double(rain(i, j, k)));
    const double fastest = find_speed();
    if (fastest <= 0) return;
    const int parts = std::max(1, int(std::ceil(dt * fastest / dz)));
    for (int s = 0; s < parts; ++s) {
        if (s > 0) find_speed();  // rain that has reached a dry cell falls on from there
        for (int k = 0; k < nz; ++k) {
            const double courant = dt / parts * speed[size_t(k)] / dz, mass = air.rho.centre[size_t(k)];
            const double leaves = std::min(1.0, courant) * q[size_t(k)] * mass;
            q[size_t(k)] -= leaves / mass;
            if (k > 0)
                q[size_t(k) - 1] += leaves / air.rho.centre[size_t(k) - 1];
            else
                sum.fallen += leaves;
        }
    }
    for (int k = 0; k < nz; ++k) rain(i, j, k) = T(q[size_t(k)]);
}

template<typename T>
void step(Air<T>& air, double dt)
{
    const auto [nx, ny, nz] = air.lattice.n;
    std::vector<Exchange> of_row(static_cast<size_t>(ny));
    for_chunks(ny, 4, [&, nx = nx, nz = nz](int j0, int j1) {
        std::vector<T> cloud(static_cast<size_t>(nx));
        std::vector<double> q(static_cast<size_t>(nz)), speed(static_cast<size_t>(nz));
        for (int j = j0; j < j1; ++j) {
            for (int k = 0; k < nz; ++k) exchange_row(air, j, k, dt, cloud, of_row[size_t(j)]);
            for (int i = 0; i < nx; ++i) fall(air, i, j, dt, q, speed, of_row[size_t(j)]);
        }
    });
    for (const Exchange& sum : of_row) {
        air.theta.sources += sum.warmed, air.water.sources += sum.wetted;
        air.rain_fallen += sum.fallen * air.parameters.constants.rho0 * air.lattice.h[2] / (double(nx) * ny);
    }
}

template<typename T>
void add(Air<T>& air)
{
    air.allocate(air.rain, Quantity::Rain);
    air.after_step.push_back([&air](double dt) { step(air, dt); });
}

}  // namespace

Effect rain()
{
    return {"rain",
            "q_r with stages, conversion and fall",
            {{"rain", "cloud turns to rain that falls and evaporates, after Kessler",
              [](Parameters& p) -> bool& { return p.rain; }},
             {"droplets",
              "droplets of cloud in a cm^3, on whose number its conversion to rain depends, after Khairoutdinov and "
              "Kogan; 0 takes Kessler's rates",
              "1/cm^3", from_zero(1e5), [](Parameters& p) -> double& { return p.droplets; }}},
            [](const Parameters& p) { return p.rain; },
            [](const Parameters& p) {
                if (p.rain && !p.moisture) throw InputError("rain without moisture: expected moisture, or no rain");
            },
            [](const Parameters& p) { return state_arrays(p); },
            {add<float>, add<double>}};
}

}  // namespace vdbcloud::sim::effect
