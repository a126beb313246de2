// Heat, water and smoke that enter through the floor, spread over the first cell: flux / dz.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/refuse.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Rates [unit/s] of the lowest cells, x fastest: the uniform flux times the map, and Gaussian patches. Empty: all 0.
template<typename T>
std::vector<T> rates_of(const Air<T>& air, double uniform, double Patch::*strength)
{
    const Lattice& l = air.lattice;
    const Floor& floor = air.parameters.floor;
    std::vector<T> map(size_t(l.n[0]) * size_t(l.n[1]));
    double most = 0;
    for (int j = 0; j < l.n[1]; ++j)
        for (int i = 0; i < l.n[0]; ++i) {
            const size_t c = size_t(j) * size_t(l.n[0]) + size_t(i);
            double flux = uniform * (floor.map.empty() ? 1 : floor.map[c]);
            for (const Patch& patch : floor.patches) {
                const double x = l.flat(0) ? 0 : (i + 0.5) * l.h[0] - patch.centre[0];
                const double y = l.flat(1) ? 0 : (j + 0.5) * l.h[1] - patch.centre[1];
                flux += patch.*strength * std::exp(-(x * x + y * y) / (patch.radius * patch.radius));
            }
            map[c] = T(flux / l.h[2] / air.rho.centre[0]);
            most = std::max(most, std::abs(flux));
        }
    return most > 0 ? map : std::vector<T>();
}

template<typename T>
void add(Air<T>& air)
{
    const Floor& floor = air.parameters.floor;
    const auto heat = [&](Variable<T>& v, double uniform, double Patch::*strength) {
        std::vector<T> map = v ? rates_of(air, uniform, strength) : std::vector<T>();
        if (map.empty()) return;
        v.terms.push_back([&air, nx = air.lattice.n[0], map = std::move(map)](int, int j, int k, T* out) {
            if (k > 0 || !air.floor_has_fluxes()) return;
            for (int i = 0; i < nx; ++i) out[i] += map[size_t(j) * size_t(nx) + size_t(i)];
        });
    };
    heat(air.theta, floor.heat, &Patch::heat);
    heat(air.water, floor.moisture, &Patch::moisture);
    heat(air.dye, 0, &Patch::dye);
}

/// One value of a patch or of the map.
void check_value(const char* name, double value, const Range& range, const char* unit)
{
    if (!range.holds(value)) refuse(name, value, range.text() + (*unit ? " " : "") + unit);
}

void check(const Parameters& p)
{
    for (const Patch& patch : p.floor.patches) {
        for (const double place : patch.centre) check_value("patch position", place, magnitude(1e9), "m");
        check_value("patch radius", patch.radius, {1e-3, 1e9}, "m");
        check_value("patch heat flux", patch.heat, magnitude(1e3), "K m/s");
        check_value("patch moisture flux", patch.moisture, from_zero(1), "kg/kg m/s");
        check_value("patch dye flux", patch.dye, from_zero(1e6), "m/s");
    }
    const std::vector<double>& map = p.floor.map;
    if (!map.empty() && map.size() != size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]))
        throw InputError("floor map of " + std::to_string(map.size()) + " values: expected one a column of the box");
    for (const double factor : map) check_value("factor of the floor map", factor, from_zero(1e6), "");
}

}  // namespace

Effect floor_fluxes()
{
    return changeable(
        {"floor fluxes",
         "",
         {{"heat-flux", "kinematic heat flux through the whole floor", "K m/s", magnitude(1e3),
           [](Parameters& p) -> double& { return p.floor.heat; }},
          {"moisture-flux", "water flux through the whole floor", "kg/kg m/s", from_zero(1),
           [](Parameters& p) -> double& { return p.floor.moisture; }},
          Setting::time("flux-until", "time at which all fluxes through the floor end", from_zero(never),
                        [](Parameters& p) -> double& { return p.floor.until; })},
         [](const Parameters& p) { return p.floor.heat != 0 || p.floor.moisture > 0 || !p.floor.patches.empty(); },
         check,
         nullptr,
         {add<float>, add<double>},
         2});
}

}  // namespace vdbcloud::sim::effect
