// The air at the start.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sim/model.h"

#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

template<typename T>
void Model<T>::set_initial_air()
{
    const auto [nx, ny, nz] = air_.lattice.n;
    const auto [dx, dy, dz] = air_.lattice.h;
    const Parameters& p = parameters_;
    const auto noise = [&](int which, int i, int j, int k) {
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
                    const double x = ((i + 0.5) * dx - b.centre[0]) / b.radius;
                    const double y = air_.lattice.flat(1) ? 0 : ((j + 0.5) * dy - b.centre[1]) / b.radius;
                    const double r = std::hypot(x, y, (level.z - b.centre[2]) / b.height);
                    if (r >= 1) continue;
                    const double shape = std::pow(std::cos(pi / 2 * r), 2);
                    theta += b.theta * shape, water += b.water * shape, smoke += b.dye * shape;
                }
                if (air_.theta) air_.theta.a[0](i, j, k) = T(theta);
                if (air_.water) air_.water.a[0](i, j, k) = T(std::max(-column_.reference.water, water));
                if (air_.dye) air_.dye.a[0](i, j, k) = T(smoke);
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
void Model<T>::set(Quantity q, const std::vector<double>& values)
{
    Variable<T>& v = air_.of(q);
    if (!v) throw InputError("initial state: a quantity was given for which this run has no field");
    if (values.size() != air_.lattice.cells())
        throw InputError("initial state: " + std::to_string(values.size()) + " values, expected one a cell");
    const double shift = air_.reference(q);
    size_t c = 0;
    for (int k = 0; k < air_.lattice.n[2]; ++k)
        for (int j = 0; j < air_.lattice.n[1]; ++j)
            for (int i = 0; i < air_.lattice.n[0]; ++i) {
                const double value = values[c++];
                if (!std::isfinite(value)) {
                    std::ostringstream text;
                    text << "initial state: value " << value << " at cell [" << i << ", " << j << ", " << k
                         << "]: expected a finite number";
                    throw InputError(text.str());
                }
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
    template void Model<T>::set(Quantity, const std::vector<double>&);                                                 \
    template void Model<T>::start();
VDBCLOUD_INITIAL(float)
VDBCLOUD_INITIAL(double)
#undef VDBCLOUD_INITIAL

}  // namespace vdbcloud::sim
