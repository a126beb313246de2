// Thin hot gas cools by radiation with the fourth power of its temperature: Nguyen, Fedkiw and Jensen 2002, eq. 11,
//
//     dT/dt = -c ((T - T_env) / (T_c - T_env))^4
//
// in the environment's T_env of each level. Each step is exact: with x = (T - T_env) / (T_c - T_env),
// x(t) = x (1 + 3 c t x^3 / (T_c - T_env))^(-1/3), which stays above 0 for any step.
#include "vdbcloud/sim/combustion.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::sim::effect {

namespace {

/// Returns what the plane gained of theta, cells weighted with the density of the base state.
template<typename T>
double cool_plane(Air<T>& air, int k, double dt)
{
    const Parameters& p = air.parameters;
    const double from = air.reference(Quantity::Theta), exner = exner_of(air, k), mass = air.rho.centre[size_t(k)];
    const double env = (air.column.level[size_t(k)].theta_env + from) * exner;
    const double span = std::max(1.0, p.cooling_temperature - env), rate = 3 * p.cooling * dt / span;
    double sum = 0;
    for (int j = 0; j < air.lattice.n[1]; ++j) {
        T* theta = air.theta.a[0].row(j, k);
        for (int i = 0; i < air.lattice.n[0]; ++i) {
            const double x = ((double(theta[i]) + from) * exner - env) / span;
            if (!(x > 0)) continue;
            const double lost = x * span * (1 - 1 / std::cbrt(1 + rate * x * x * x));
            const T cooled = T(double(theta[i]) - lost / exner);
            sum += (double(cooled) - double(theta[i])) * mass;
            theta[i] = cooled;
        }
    }
    return sum;
}

template<typename T>
void add(Air<T>& air)
{
    air.after_step.push_back([&air](double dt) {
        air.theta.gain(reduce_planes(
            air.lattice.n[2], 0.0, [&](int k) { return cool_plane(air, k, dt); },
            [](double a, double b) { return a + b; }));
    });
}

}  // namespace

Effect cooling()
{
    return changeable({"cooling of hot gas",
                       "",
                       {{"cooling",
                         "cooling of air at --cooling-temperature by its own radiation, which falls with the "
                         "fourth power of (T - T_env); 0 is off",
                         "K/s", from_zero(1e7), [](Parameters& p) -> double& { return p.cooling; }},
                        {"cooling-temperature",
                         "temperature of --cooling",
                         "K",
                         {100, 1e4},
                         [](Parameters& p) -> double& { return p.cooling_temperature; }}},
                       [](const Parameters& p) { return p.cooling > 0; },
                       [](const Parameters& p) {
                           if (p.cooling > 0 && !p.buoyancy && !p.moisture)
                               throw InputError("cooling without heat: expected buoyancy");
                       },
                       nullptr,
                       {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
