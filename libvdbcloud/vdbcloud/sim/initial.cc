// The air at the start.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/model.h"

#include <array>
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
    default: return {"dye", "", from_zero(1e6), ""};
    }
}

/// Throws InputError that names `source`, the quantity, its value and the cell.
void expect_allowed(Quantity q, double value, const std::array<int, 3>& cell, const std::string& source)
{
    const Allowed a = allowed(q);
    if (a.range.holds(value)) return;
    std::ostringstream text, expected;
    text << source << ": " << a.name << " in cell [" << cell[0] << ", " << cell[1] << ", " << cell[2] << "]";
    expected << a.range.text() << (*a.unit ? " " : "") << a.unit << a.because;
    refuse(text.str(), value, expected.str());
}

}  // namespace

template<typename T>
void Model<T>::set_initial_air()
{
    const auto [nx, ny, nz] = air_.lattice.n;
    const auto [dx, dy, dz] = air_.lattice.h;
    const Parameters& p = parameters_;
    // A slice along y has the noise of the slice along x.
    const bool along_y = air_.lattice.flat(0);
    const auto noise = [&](int which, int i, int j, int k) {
        if (along_y) std::swap(i, j);
        return 2 * uniform(hash_bits(p.noise.seed, uint64_t(which), uint64_t(i), uint64_t(j), uint64_t(k))) - 1;
    };
    for (int k = 0; k < nz; ++k) {
        const Level& level = column_.level[size_t(k)];
        const bool noisy = level.z < p.noise.below;
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                double theta = level.theta_env, water = level.q_env, smoke = 0;
                if (noisy) theta += p.noise.theta * noise(0, i, j, k), water += p.noise.water * noise(1, i, j, k);
                for (const Bubble& b : p.bubbles) {
                    const double x = air_.lattice.flat(0) ? 0 : ((i + 0.5) * dx - b.centre[0]) / b.radius;
                    const double y = air_.lattice.flat(1) ? 0 : ((j + 0.5) * dy - b.centre[1]) / b.radius;
                    const double r = std::hypot(x, y, (level.z - b.centre[2]) / b.height);
                    if (r >= 1) continue;
                    const double shape = std::pow(std::cos(pi / 2 * r), 2);
                    theta += b.theta * shape, water += b.water * shape, smoke += b.dye * shape;
                }
                water = std::max(-column_.reference.water, water);
                const auto expect = [&](Quantity q, double value) {
                    expect_allowed(q, value + air_.reference(q), {i, j, k}, "initial air");
                };
                if (air_.theta) expect(Quantity::Theta, theta), air_.theta.a[0](i, j, k) = T(theta);
                if (air_.water) expect(Quantity::Water, water), air_.water.a[0](i, j, k) = T(water);
                if (air_.dye) expect(Quantity::Dye, smoke), air_.dye.a[0](i, j, k) = T(smoke);
                if (air_.wind[0]) air_.wind[0].a[0](i, j, k) = T(column_.u[size_t(k)]);
                if (air_.wind[1]) air_.wind[1].a[0](i, j, k) = T(column_.v[size_t(k)]);
            }
        if (air_.wind[0] && air_.lattice.side[0] == Side::Open)
            for (int j = 0; j < ny; ++j) air_.wind[0].a[0](nx, j, k) = T(column_.u[size_t(k)]);
        if (air_.wind[1] && air_.lattice.side[1] == Side::Open)
            for (int i = 0; i < nx; ++i) air_.wind[1].a[0](i, ny, k) = T(column_.v[size_t(k)]);
    }
}

template<typename T>
void Model<T>::set(Quantity q, const std::vector<double>& values, const std::string& source)
{
    Variable<T>& v = air_.of(q);
    if (!v) throw InputError(source + ": a quantity was given for which this run has no field");
    if (values.size() != air_.lattice.cells())
        throw InputError(source + ": " + std::to_string(values.size()) + " values, expected one a cell");
    const double shift = air_.reference(q);
    size_t c = 0;
    for (int k = 0; k < air_.lattice.n[2]; ++k)
        for (int j = 0; j < air_.lattice.n[1]; ++j)
            for (int i = 0; i < air_.lattice.n[0]; ++i) {
                const double value = values[c++];
                expect_allowed(q, value, {i, j, k}, source);
                v.a[0](i, j, k) = T(value - shift);
            }
    started_ = false;
}

template<typename T>
void Model<T>::start()
{
    if (parameters_.momentum) project(0);
    finish_state(0);
    take_courant(0);
    started_ = true;
    for (Variable<T>* v : air_.scalars()) v->start = extent(*v);
}

#define VDBCLOUD_INITIAL(T)                                                                                            \
    template void Model<T>::set_initial_air();                                                                         \
    template void Model<T>::set(Quantity, const std::vector<double>&, const std::string&);                             \
    template void Model<T>::start();
VDBCLOUD_INITIAL(float)
VDBCLOUD_INITIAL(double)
#undef VDBCLOUD_INITIAL

}  // namespace vdbcloud::sim
