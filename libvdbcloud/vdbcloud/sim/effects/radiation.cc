// Long-wave cooling of cloud: net flux F exp(-kappa LWP above); heating = -(1 / rho cp) dF/dz, of theta.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Heating rates [K/s] of theta by the cloud in the arrays `at`, column by column from the lid down.
template<typename T>
void find_heating(const Air<T>& air, int at, Field<T>& heating)
{
    const auto [nx, ny, nz] = air.lattice.n;
    const Parameters& p = air.parameters;
    const double dz = air.lattice.h[2];
    for_chunks(ny, 4, [&, nx = nx, nz = nz](int j0, int j1) {
        std::vector<T> cloud(static_cast<size_t>(nx));
        std::vector<double> path(static_cast<size_t>(nx));
        for (int j = j0; j < j1; ++j) {
            std::fill(path.begin(), path.end(), 0.0);
            for (int k = nz - 1; k >= 0; --k) {
                const Level& level = air.column.level[size_t(k)];
                const double rho = p.constants.rho0 * air.rho.centre[size_t(k)];
                air.thermo.cloud_row(level, air.theta.a[size_t(at)].row(j, k), air.water.a[size_t(at)].row(j, k),
                                     cloud.data(), nx);
                T* out = heating.row(j, k);
                for (int i = 0; i < nx; ++i) {
                    const double lower = path[size_t(i)] + rho * double(cloud[size_t(i)]) * dz;
                    const double divergence = p.radiation * (std::exp(-p.radiation_kappa * path[size_t(i)]) -
                                                             std::exp(-p.radiation_kappa * lower));
                    out[i] = T(-divergence / (rho * p.constants.cp * dz * level.exner));
                    path[size_t(i)] = lower;
                }
            }
        }
    });
}

template<typename T>
void add(Air<T>& air)
{
    Field<T>& heating = air.add_field();
    air.before_stage.push_back([&air, &heating](int in) { find_heating(air, in, heating); });
    air.theta.terms.push_back([&heating, n = air.lattice.n[0]](int, int j, int k, T* out) {
        const T* rate = heating.row(j, k);
        for (int i = 0; i < n; ++i) out[i] += rate[i];
    });
}

}  // namespace

Effect radiation()
{
    return changeable({"radiation",
                       "heating rate, column sums",
                       {{"radiation", "net long-wave flux that a cloud top loses to space; 70 is usual, 0 is off",
                         "W/m^2", from_zero(1e5), [](Parameters& p) -> double& { return p.radiation; }},
                        {"radiation-kappa", "absorption of long-wave radiation by cloud water", "m^2/kg",
                         from_zero(1e6), [](Parameters& p) -> double& { return p.radiation_kappa; }}},
                       [](const Parameters& p) { return p.radiation > 0; },
                       [](const Parameters& p) {
                           if (p.radiation > 0 && !p.moisture)
                               throw InputError("radiation of cloud without moisture: expected moisture");
                       },
                       [](const Parameters&) { return 1; },
                       {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
