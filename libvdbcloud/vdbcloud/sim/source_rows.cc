// What sinks and held air do to a row, and what bodies hold.
#include "vdbcloud/sim/model.h"

#include <algorithm>

namespace vdbcloud::sim {

/// Adds what sinks take out of a row, no more than leaves `least` after a forward step of length tau. Returns the sum.
template<typename T>
double Model<T>::take_out(const Variable<T>& v, int in, int j, int k, const Stock& stock, T* tendency)
{
    T taken[4096];
    const int nx = air_.lattice.n[0];
    std::fill_n(taken, nx, T(0));
    for (const auto& sink : v.sinks) sink(in, j, k, taken);
    double sum = 0;
    for (int i = 0; i < nx; ++i) {
        const T left = T(stock.least - double(stock.x[i])) / T(stock.tau) - tendency[i];
        const T change = std::max(taken[i], std::min(T(0), left));
        tendency[i] += change, sum += double(change);
    }
    return sum;
}

/// Holds a row at what sources prescribe. Returns the sum of the changes.
template<typename T>
double Model<T>::hold(const Variable<T>& v, double dt, int j, int k, T* row, int n)
{
    double before = 0, after = 0;
    for (int i = 0; i < n; ++i) before += double(row[i]);
    for (const auto& change : v.holds) change(dt, j, k, row);
    for (int i = 0; i < n; ++i) after += double(row[i]);
    return after - before;
}

/// Cells within bodies hold the environment's air and no dye, and keep it: nothing flows there.
template<typename T>
void Model<T>::clear_bodies()
{
    if (!air_.bodies) return;
    const auto [nx, ny, nz] = air_.lattice.n;
    size_t c = 0;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i, ++c) {
                if (!air_.bodies.solid[c]) continue;
                for (Variable<T>* v : air_.scalars()) v->a[0](i, j, k) = T(0);
                if (air_.theta) air_.theta.a[0](i, j, k) = T(column_.level[size_t(k)].theta_env);
                if (air_.water) air_.water.a[0](i, j, k) = T(column_.level[size_t(k)].q_env);
            }
}

#define VDBCLOUD_SOURCE_ROWS(T)                                                                                        \
    template double Model<T>::take_out(const Variable<T>&, int, int, int, const Stock&, T*);                           \
    template double Model<T>::hold(const Variable<T>&, double, int, int, T*, int);                                     \
    template void Model<T>::clear_bodies();
VDBCLOUD_SOURCE_ROWS(float)
VDBCLOUD_SOURCE_ROWS(double)
#undef VDBCLOUD_SOURCE_ROWS

}  // namespace vdbcloud::sim
