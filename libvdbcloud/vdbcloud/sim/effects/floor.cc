// Heat, water and smoke that enter through the floor, spread over the first cell: flux / dz.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/refuse.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace vdbcloud::sim::effect {

namespace {

/// One kind of flux: the uniform one, times the map, and that of Gaussian patches.
struct Flux {
    double uniform;
    double Patch::*strength;
};

/// The flux out of cell (i, j) of the ground: the cells of the box at time 0, which go on beyond periodic sides with
/// the opposite ones. Beyond other sides a map is 0.
double flux_of(const Parameters& p, const Flux& kind, int i, int j)
{
    const Lattice& l = p.lattice;
    const Floor& floor = p.floor;
    const auto wrapped = [&](int c, size_t axis) {
        return l.side[axis] == Side::Periodic ? ((c % l.n[axis]) + l.n[axis]) % l.n[axis] : c;
    };
    i = wrapped(i, 0), j = wrapped(j, 1);
    const bool mapped = i >= 0 && i < l.n[0] && j >= 0 && j < l.n[1];
    double flux = kind.uniform * (floor.map.empty() ? 1
                                  : mapped          ? floor.map[size_t(j) * size_t(l.n[0]) + size_t(i)]
                                                    : 0);
    for (const Patch& patch : floor.patches) {
        const double x = l.flat(0) ? 0 : (i + 0.5) * l.h[0] - patch.centre[0];
        const double y = l.flat(1) ? 0 : (j + 0.5) * l.h[1] - patch.centre[1];
        flux += patch.*kind.strength * std::exp(-(x * x + y * y) / (patch.radius * patch.radius));
    }
    return flux;
}

/// Rates [unit/s] of the lowest cells, x fastest, of a box that has moved over the ground: linear between the ground's
/// cells, so that no flux is lost. Empty: all 0.
template<typename T>
std::vector<T> rates_of(const Air<T>& air, const Flux& kind, const std::array<double, 2>& moved)
{
    const Lattice& l = air.lattice;
    int whole[2] = {0, 0};
    double part[2] = {0, 0};
    for (const size_t d : {0, 1}) {
        const double cells = moved[d] / l.h[d], nearest = std::round(cells);
        // What is a whole number of cells but for the rounding of the time is one.
        const double at = std::abs(cells - nearest) < 1e-9 * std::max(1.0, std::abs(cells)) ? nearest : cells;
        const double below = std::floor(at);
        part[d] = at - below;
        whole[d] = int(l.side[d] == Side::Periodic ? std::fmod(below, double(l.n[d])) : std::clamp(below, -1e9, 1e9));
    }
    std::vector<T> map(size_t(l.n[0]) * size_t(l.n[1]));
    double most = 0;
    for (int j = 0; j < l.n[1]; ++j)
        for (int i = 0; i < l.n[0]; ++i) {
            const size_t c = size_t(j) * size_t(l.n[0]) + size_t(i);
            double flux = 0;
            for (const int b : {0, 1})
                for (const int a : {0, 1}) {
                    const double weight = (a ? part[0] : 1 - part[0]) * (b ? part[1] : 1 - part[1]);
                    if (weight > 0) flux += weight * flux_of(air.parameters, kind, i + whole[0] + a, j + whole[1] + b);
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
    const auto heat = [&](Variable<T>& v, const Flux& kind) {
        const bool any = kind.uniform != 0 || std::any_of(floor.patches.begin(), floor.patches.end(),
                                                          [&](const Patch& p) { return p.*kind.strength != 0; });
        if (!v || !any) return;
        const auto map = std::make_shared<std::vector<T>>(rates_of(air, kind, {0, 0}));
        if (map->empty() && !air.moves()) return;
        if (air.moves())
            air.before_stage.push_back(
                [&air, kind, map](int) { *map = rates_of(air, kind, air.moved(air.stage_time)); });
        auto& list = air.bodies ? v.terms : v.floor;
        list.push_back([&air, nx = air.lattice.n[0], map](int, int j, int k, T* out) {
            if (map->empty() || !air.floor_has_fluxes()) return;
            const size_t row = size_t(j) * size_t(nx);
            const std::vector<int>& ground = air.bodies.ground;
            if (ground.empty())
                for (int i = 0; i < nx; ++i) out[i] += (*map)[row + size_t(i)];
            const T lighter = T(air.rho.centre[0] / air.rho.centre[size_t(k)]);
            for (int i = 0; i < nx && !ground.empty(); ++i)
                if (ground[row + size_t(i)] == k) out[i] += lighter * (*map)[row + size_t(i)];
        });
    };
    heat(air.theta, {floor.heat, &Patch::heat});
    heat(air.water, {floor.moisture, &Patch::moisture});
    heat(air.dye, {0, &Patch::dye});
    heat(air.fuel, {0, &Patch::fuel});
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
        check_value("patch fuel flux", patch.fuel, from_zero(1e6), "m/s");
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
