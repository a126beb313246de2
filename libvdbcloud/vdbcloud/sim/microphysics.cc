// Warm rain after Kessler 1969, in the form of Klemp and Wilhelmson 1978, column by column between steps.
#include "vdbcloud/sim/model.h"

#include <cmath>

namespace vdbcloud::sim {

/// Cloud above 1 g/kg turns to rain at 1e-3 /s, rain collects cloud at 2.2 q_r^0.875 /s, evaporates where the air is
/// not saturated, and falls at 36.34 (rho q_r)^0.1346 sqrt(rho_floor / rho) m/s (rho in g/cm^3), upwind, in sub-steps
/// of its own Courant number. theta_l counts only cloud water: cloud that becomes rain leaves its heat, evaporation
/// takes it back.
template<typename T>
void Model<T>::rain(double dt)
{
    const auto [nx, ny, nz] = lattice_.n;
    const Constants& c = parameters_.constants;
    const double dz = lattice_.h[2];
    std::vector<double> fallen(size_t(ny), 0.0), warmed(size_t(ny), 0.0), dried(size_t(ny), 0.0);
    for_blocks(ny, 4, [&, nx = nx, nz = nz](int j0, int j1) {
        std::vector<T> cloud(static_cast<size_t>(nx));
        std::vector<double> speed(static_cast<size_t>(nz)), q(static_cast<size_t>(nz));
        for (int j = j0; j < j1; ++j) {
            for (int k = 0; k < nz; ++k) {
                const Level& level = column_.level[size_t(k)];
                T *theta = theta_.a[0].row(j, k), *water = water_.a[0].row(j, k), *drops = rain_.a[0].row(j, k);
                thermo_.cloud_row(level, theta, water, cloud.data(), nx);
                const double warm = parameters_.moist.latent_heat ? level.heat : 0;
                const Reference& reference = column_.reference;
                for (int i = 0; i < nx; ++i) {
                    const double q_c = double(cloud[size_t(i)]), q_r = std::max(0.0, double(drops[i]));
                    if (q_c <= 0 && q_r <= 0) continue;
                    double change = dt * (1e-3 * std::max(0.0, q_c - 1e-3) + 2.2 * q_c * std::pow(q_r, 0.875));
                    change = std::min(change, q_c);
                    if (q_c <= 0) {
                        const double t = (double(theta[i]) + reference.theta) * level.exner;
                        const double q_s = parameters_.moist.by == SaturationBy::Height
                                               ? level.q_height
                                               : thermo_.saturation(t, level.pressure);
                        const double q_t = double(water[i]) + reference.water;
                        const double dry = 1 - q_t / q_s, rho = 1e-3 * c.rho0 * rho_.centre[size_t(k)];
                        const double vent = 1.6 + 124.9 * std::pow(rho * q_r, 0.2046);
                        const double rate =
                            dry * vent * std::pow(rho * q_r, 0.525) / ((5.4e5 + 2.55e8 / (level.pressure * q_s)) * rho);
                        // Not more than there is, nor so much that the cooled air would be above saturation.
                        change = -std::min({dt * std::max(0.0, rate), q_r, 0.25 * std::max(0.0, q_s - q_t)});
                    }
                    const T q_left = T(double(water[i]) - change), q_rain = T(q_r + change),
                            t_l = T(double(theta[i]) + warm * change);
                    warmed[size_t(j)] += (double(t_l) - double(theta[i])) * rho_.centre[size_t(k)];
                    dried[size_t(j)] += (double(q_left) - double(water[i])) * rho_.centre[size_t(k)];
                    water[i] = q_left, drops[i] = q_rain, theta[i] = t_l;
                }
            }
            for (int i = 0; i < nx; ++i) {
                double fastest = 0;
                for (int k = 0; k < nz; ++k) {
                    const double rho = rho_.centre[size_t(k)];
                    q[size_t(k)] = std::max(0.0, double(rain_.a[0](i, j, k)));
                    speed[size_t(k)] = 36.34 * std::pow(1e-3 * c.rho0 * rho * q[size_t(k)], 0.1346) / std::sqrt(rho);
                    fastest = std::max(fastest, speed[size_t(k)]);
                }
                if (fastest <= 0) continue;
                const int parts = std::max(1, int(std::ceil(dt * fastest / dz)));
                for (int s = 0; s < parts; ++s)
                    for (int k = 0; k < nz; ++k) {
                        const double courant = dt / parts * speed[size_t(k)] / dz, mass = rho_.centre[size_t(k)];
                        const double leaves = std::min(1.0, courant) * q[size_t(k)] * mass;
                        q[size_t(k)] -= leaves / mass;
                        if (k > 0)
                            q[size_t(k) - 1] += leaves / rho_.centre[size_t(k) - 1];
                        else
                            fallen[size_t(j)] += leaves;
                    }
                for (int k = 0; k < nz; ++k) rain_.a[0](i, j, k) = T(q[size_t(k)]);
            }
        }
    });
    for (int j = 0; j < ny; ++j) {
        theta_.sources += warmed[size_t(j)], water_.sources += dried[size_t(j)];
        rain_fallen_ += fallen[size_t(j)] * c.rho0 * dz / (double(nx) * ny);
    }
    finish_state(0);
}

template void Model<float>::rain(double);
template void Model<double>::rain(double);

}  // namespace vdbcloud::sim
