// The air at the start.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/first_air.h"
#include "vdbcloud/sim/model.h"

namespace vdbcloud::sim {

template<typename T>
void Model<T>::set_initial_air()
{
    const auto [nx, ny, nz] = air_.lattice.n;
    const FirstAir first(parameters_, column_);
    for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const CellAir cell = first.at(i, j, k);
                if (air_.theta) air_.theta.a[0](i, j, k) = T(cell.theta);
                if (air_.water) air_.water.a[0](i, j, k) = T(cell.water);
                if (air_.dye) air_.dye.a[0](i, j, k) = T(cell.dye);
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
    clear_bodies();
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
