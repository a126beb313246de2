// Fuel that burns to heat and soot, between steps. In a cell above the ignition temperature
//
//     dY/dt = -b / time,   dT/dt = heat b / time,   d dye/dt = soot b / time,   b = min(Y, (T_flame - T) / heat)
//
// each step exactly, by the factor exp(-dt / time). Feldman, O'Brien and Arikan 2003 burn fuel at a rate above an
// ignition temperature and make heat and soot in proportion; so do Horvath and Geiger 2009. The bound on b stands for
// oxygen, which is not transported: air that fuel has heated to T_flame has none left, so that rich gas burns where it
// has mixed with air or cooled. No expansion: the air stays incompressible, and hot gas rises by its buoyancy.
#include "vdbcloud/sim/combustion.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::sim::effect {

namespace {

/// What a plane gained, cells weighted with the density of the base state.
struct Gains {
    double heat = 0, fuel = 0, dye = 0;
};

template<typename T>
Gains burn_plane(Air<T>& air, int k, double burnt_share)
{
    const Combustion& c = air.parameters.combustion;
    const double from = air.reference(Quantity::Theta), exner = exner_of(air, k), mass = air.rho.centre[size_t(k)];
    Gains sum;
    for (int j = 0; j < air.lattice.n[1]; ++j) {
        T *theta = air.theta.a[0].row(j, k), *fuel = air.fuel.a[0].row(j, k), *dye = air.dye.a[0].row(j, k);
        for (int i = 0; i < air.lattice.n[0]; ++i) {
            const double temperature = (double(theta[i]) + from) * exner;
            const double burnt = burnt_share * burnable(c, double(fuel[i]), temperature);
            if (burnt <= 0) continue;
            const T left = T(double(fuel[i]) - burnt), warm = T(double(theta[i]) + c.heat * burnt / exner),
                    soot = T(double(dye[i]) + c.soot * burnt);
            sum.fuel += (double(left) - double(fuel[i])) * mass;
            sum.heat += (double(warm) - double(theta[i])) * mass;
            sum.dye += (double(soot) - double(dye[i])) * mass;
            fuel[i] = left, theta[i] = warm, dye[i] = soot;
        }
    }
    return sum;
}

template<typename T>
void burn(Air<T>& air, double dt)
{
    const double share = -std::expm1(-dt / air.parameters.combustion.time);
    const Gains sum = reduce_planes(
        air.lattice.n[2], Gains{}, [&](int k) { return burn_plane(air, k, share); },
        [](const Gains& a, const Gains& b) {
            return Gains{a.heat + b.heat, a.fuel + b.fuel, a.dye + b.dye};
        });
    air.theta.gain(sum.heat), air.fuel.gain(sum.fuel), air.dye.gain(sum.dye);
}

template<typename T>
void add(Air<T>& air)
{
    air.allocate(air.fuel, Quantity::Fuel);
    air.after_step.push_back([&air](double dt) { burn(air, dt); });
}

void check(const Parameters& p)
{
    const Combustion& c = p.combustion;
    if (!c.on) {
        for (const Patch& patch : p.floor.patches)
            if (patch.fuel != 0) throw InputError("fuel of a patch without combustion: expected combustion");
        return;
    }
    if (!p.buoyancy && !p.moisture) throw InputError("combustion without heat: expected buoyancy");
    if (!p.dye) throw InputError("combustion without dye, which is its soot: expected dye");
    if (!(c.flame > c.ignition))
        throw InputError("flame temperature " + std::to_string(c.flame) + " K: expected above the ignition, " +
                         std::to_string(c.ignition) + " K");
}

}  // namespace

Effect combustion()
{
    return {"combustion",
            "fuel with stages",
            {{"combustion", "the air carries fuel, which burns to heat and soot (dye): needs --dye on",
              [](Parameters& p) -> bool& { return p.combustion.on; }},
             Setting::time("burn-time", "time in which fuel burns to 1/e", {1e-6, any_finite},
                           [](Parameters& p) -> double& { return p.combustion.time; }),
             {"burn-heat", "warming of air by fuel 1", "K", above_zero(1e5),
              [](Parameters& p) -> double& { return p.combustion.heat; }},
             {"soot", "dye that fuel 1 leaves", "", from_zero(1e6),
              [](Parameters& p) -> double& { return p.combustion.soot; }},
             {"ignition", "temperature above which fuel burns", "K", from_zero(1e4),
              [](Parameters& p) -> double& { return p.combustion.ignition; }},
             {"flame-temperature", "no burning heats air above this temperature", "K", above_zero(1e4),
              [](Parameters& p) -> double& { return p.combustion.flame; }}},
            [](const Parameters& p) { return p.combustion.on; },
            check,
            [](const Parameters& p) { return state_arrays(p); },
            {add<float>, add<double>}};
}

}  // namespace vdbcloud::sim::effect
