#include "vdbcloud/sim/first_air.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/sim/effect.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace vdbcloud::sim {

namespace {

/// What a value of the first air may be.
struct Allowed {
    const char* name;
    const char* unit;
    Range range;
    const char* because;
};

Allowed allowed(Quantity q)
{
    const Range speed = magnitude(allowed_speed);
    const char* sound = " (the equations have no sound: Mach 0.3 is 100 m/s)";
    switch (q) {
    case Quantity::U: return {"u", "m/s", speed, sound};
    case Quantity::V: return {"v", "m/s", speed, sound};
    case Quantity::W: return {"w", "m/s", speed, sound};
    case Quantity::Theta: return {"theta_l", "K", allowed_theta, ""};
    case Quantity::Water: return {"q_t", "kg/kg", from_zero(1), ""};
    case Quantity::Rain: return {"rain", "kg/kg", from_zero(1), ""};
    case Quantity::Fuel: return {"fuel", "", from_zero(1e6), ""};
    default: return {"dye", "", from_zero(1e6), ""};
    }
}

double reference_of(const Column& column, Quantity q)
{
    return q == Quantity::Theta ? column.reference.theta : q == Quantity::Water ? column.reference.water : 0;
}

/// Quantities of the first air that a run has.
bool has(const Parameters& p, Quantity q)
{
    return q == Quantity::Theta ? p.buoyancy || p.moisture : q == Quantity::Water ? p.moisture : p.dye;
}

}  // namespace

void expect_allowed(Quantity q, double value, const std::array<int, 3>& cell, const std::string& source)
{
    const Allowed a = allowed(q);
    if (a.range.holds(value)) return;
    std::ostringstream text, expected;
    text << source << ": " << a.name << " in cell [" << cell[0] << ", " << cell[1] << ", " << cell[2] << "]";
    expected << a.range.text() << (*a.unit ? " " : "") << a.unit << a.because;
    refuse(text.str(), value, expected.str());
}

CellAir FirstAir::at(int i, int j, int k) const
{
    const Parameters& p = parameters_;
    const double dx = p.lattice.h[0], dy = p.lattice.h[1];
    const Level& level = column_.level[size_t(k)];
    // A slice along y has the noise of the slice along x.
    const auto [along_x, along_y] = p.lattice.flat(0) ? std::pair{j, i} : std::pair{i, j};
    const auto noise = [&, x = uint64_t(along_x), y = uint64_t(along_y)](int which) {
        return 2 * uniform(hash_bits(p.noise.seed, uint64_t(which), x, y, uint64_t(k))) - 1;
    };
    CellAir air{level.theta_env, level.q_env, 0};
    if (level.z < p.noise.below) air.theta += p.noise.theta * noise(0), air.water += p.noise.water * noise(1);
    for (const Bubble& b : p.bubbles) {
        const double x = p.lattice.flat(0) ? 0 : ((i + 0.5) * dx - b.centre[0]) / b.radius;
        const double y = p.lattice.flat(1) ? 0 : ((j + 0.5) * dy - b.centre[1]) / b.radius;
        const double r = std::hypot(x, y, (level.z - b.centre[2]) / b.height);
        if (r >= 1) continue;
        const double shape = std::pow(std::cos(pi / 2 * r), 2);
        air.theta += b.theta * shape, air.water += b.water * shape, air.dye += b.dye * shape;
    }
    air.water = std::max(-column_.reference.water, air.water);
    return air;
}

void FirstAir::check(const CellAir& air, int i, int j, int k) const
{
    for (const auto& [q, value] :
         {std::pair{Quantity::Theta, air.theta}, {Quantity::Water, air.water}, {Quantity::Dye, air.dye}})
        if (has(parameters_, q)) expect_allowed(q, value + reference_of(column_, q), {i, j, k}, "initial air");
}

bool FirstAir::surely_allowed() const
{
    const Parameters& p = parameters_;
    double cold = -p.noise.theta, warm = p.noise.theta, wet = p.noise.water, dye = 0;
    for (const Bubble& b : p.bubbles) {
        cold += std::min(0.0, b.theta), warm += std::max(0.0, b.theta);
        wet += std::max(0.0, b.water), dye += std::max(0.0, b.dye);
    }
    return std::all_of(column_.level.begin(), column_.level.end(), [&](const Level& level) {
        const double theta = level.theta_env + column_.reference.theta;
        return allowed(Quantity::Theta).range.holds(theta + cold) &&
               allowed(Quantity::Theta).range.holds(theta + warm) &&
               allowed(Quantity::Water).range.holds(level.q_env + column_.reference.water + wet) &&
               allowed(Quantity::Dye).range.holds(dye);
    });
}

void FirstAir::check_all() const
{
    if (surely_allowed()) return;
    const auto [nx, ny, nz] = parameters_.lattice.n;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) check(at(i, j, k), i, j, k);
}

}  // namespace vdbcloud::sim
