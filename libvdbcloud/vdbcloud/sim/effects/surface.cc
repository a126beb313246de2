// The surface layer: stress on the wind and exchange of heat and water with the surface, from the values of each of the
// lowest cells. |V| is their horizontal wind.
//
//     stress / rho    u*^2 V/|V| + C_m |V| V                       [m^2/s^2]
//     heat flux       C_h |V| (theta_surface - theta_l)            [K m/s]
//     water flux      C_q |V| (q_s(T_surface, p_surface) - q_t)    [kg/kg m/s]
#include "vdbcloud/sim/cross_wind.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Rates [1/s] at which a flux of 1 changes the lowest cells.
template<typename T>
T per_depth(const Air<T>& air)
{
    return T(1 / (air.lattice.h[2] * air.rho.centre[0]));
}

/// A step takes at most half of what a cell has, so that air at rest does not turn round.
template<typename T>
T fastest_of(const Air<T>& air)
{
    return T(0.5 / std::max(air.dt, 1e-30));
}

template<typename T>
void add_stress(Air<T>& air)
{
    const Surface& s = air.parameters.surface;
    const T prescribed = T(s.friction_velocity * s.friction_velocity), drag = T(s.drag);
    for (const int axis : {0, 1}) {
        Variable<T>& v = air.wind[size_t(axis)];
        if (!v) continue;
        v.floor.push_back([&air, &v, axis, prescribed, drag, per = per_depth(air)](int in, int j, int k, T* out) {
            const CrossWind<T> other(air, axis, in, j, k);
            const T *relative = v.a[size_t(in)].row(j, k), frame = T(air.reference(v.quantity));
            const T fastest = fastest_of(air), tiny = std::numeric_limits<T>::min();
            for (int i = 0; i < air.width(v); ++i) {
                const T u = relative[i] + frame, across = other.at(i), speed = std::sqrt(u * u + across * across);
                const T rate = per * (prescribed / std::max(speed, tiny) + drag * speed);
                out[i] -= std::min(rate, fastest) * u;
            }
        });
    }
}

/// `surface`: the value at the surface, relative to what the field is relative to.
template<typename T>
void add_flux(Air<T>& air, Variable<T>& v, double exchange, double surface)
{
    if (!v || exchange == 0) return;
    v.floor.push_back(
        [&air, &v, coefficient = T(exchange) * per_depth(air), value = T(surface)](int in, int j, int k, T* out) {
            const CentredWind<T> u(air, 0, in, j, k), w(air, 1, in, j, k);
            const T* q = v.a[size_t(in)].row(j, k);
            const T fastest = fastest_of(air);
            for (int i = 0; i < air.lattice.n[0]; ++i) {
                const T a = u.at(i), b = w.at(i);
                out[i] += std::min(coefficient * std::sqrt(a * a + b * b), fastest) * (value - q[i]);
            }
        });
}

template<typename T>
void add_exchange(Air<T>& air)
{
    const Parameters& p = air.parameters;
    const bool real = p.moist.by == SaturationBy::Temperature;
    const double exner = real ? std::pow(air.column.floor_pressure / 1e5, p.constants.r_dry / p.constants.cp) : 1;
    const double wet = real ? air.thermo.saturation(p.surface.temperature, air.column.floor_pressure) : p.q_surface;
    add_flux(air, air.theta, p.surface.heat_exchange, p.surface.temperature / exner - air.reference(Quantity::Theta));
    add_flux(air, air.water, p.surface.water_exchange, wet - air.reference(Quantity::Water));
}

}  // namespace

Effect surface_stress()
{
    return changeable(
        {"surface stress",
         "",
         {{"friction-velocity", "u* of a surface stress u*^2 against the wind; 0 is off", "m/s", from_zero(100),
           [](Parameters& p) -> double& { return p.surface.friction_velocity; }},
          {"surface-drag", "coefficient C of a surface stress C |V|^2 against the wind; 0 is off", "", from_zero(1),
           [](Parameters& p) -> double& { return p.surface.drag; }}},
         [](const Parameters& p) { return p.momentum && (p.surface.friction_velocity > 0 || p.surface.drag > 0); },
         [](const Parameters& p) {
             if (p.surface.friction_velocity > 0 && p.surface.drag > 0)
                 throw InputError("a friction velocity and a drag coefficient: expected one of the two");
         },
         nullptr,
         {add_stress<float>, add_stress<double>},
         2});
}

Effect surface_exchange()
{
    return changeable(
        {"surface exchange",
         "",
         {{"heat-exchange", "coefficient C of the surface heat flux C |V| (theta_surface - theta_l); 0 is off", "",
           from_zero(1), [](Parameters& p) -> double& { return p.surface.heat_exchange; }},
          {"water-exchange", "coefficient C of the surface water flux C |V| (q_s(surface) - q_t); 0 is off", "",
           from_zero(1), [](Parameters& p) -> double& { return p.surface.water_exchange; }},
          {"surface-temperature", "temperature of the surface, e.g. of the sea", "K", Range{150, 370},
           [](Parameters& p) -> double& { return p.surface.temperature; }}},
         [](const Parameters& p) {
             return ((p.buoyancy || p.moisture) && p.surface.heat_exchange > 0) ||
                    (p.moisture && p.surface.water_exchange > 0);
         },
         nullptr,
         nullptr,
         {add_exchange<float>, add_exchange<double>},
         2});
}

}  // namespace vdbcloud::sim::effect
