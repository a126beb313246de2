// The longest step of the present air.
#include "vdbcloud/sim/model.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim {

template<typename T>
double Model<T>::stratification() const
{
    if (!air_.theta || !parameters_.buoyancy || air_.lattice.n[2] < 2) return 0;
    const auto [nx, ny, nz] = air_.lattice.n;
    const bool hot = parameters_.moist.hot;
    const T theta0 = T(parameters_.constants.theta0), from = T(air_.reference(Quantity::Theta));
    const double steepest = reduce_planes(
        nz - 1, 0.0,
        [&, nx = nx, ny = ny](int k) {
            T most[16] = {};
            for (int j = 0; j < ny; ++j) {
                const T *a = air_.theta.a[0].row(j, k), *b = air_.theta.a[0].row(j, k + 1);
                for (int i = 0; i < nx; ++i) {
                    const T d =
                        hot ? theta0 * std::abs(b[i] - a[i]) / (std::min(a[i], b[i]) + from) : std::abs(b[i] - a[i]);
                    most[i & 15] = d > most[i & 15] ? d : most[i & 15];
                }
            }
            return double(*std::max_element(most, most + 16));
        },
        [](double a, double b) { return std::max(a, b); });
    return std::sqrt(parameters_.constants.g / parameters_.constants.theta0 * steepest / air_.lattice.h[2]);
}

template<typename T>
double Model<T>::step_limit() const
{
    return sim::step_limit(parameters_, rate_, stratification());
}

#define VDBCLOUD_STEP_LIMIT(T)                                                                                         \
    template double Model<T>::stratification() const;                                                                  \
    template double Model<T>::step_limit() const;
VDBCLOUD_STEP_LIMIT(float)
VDBCLOUD_STEP_LIMIT(double)
#undef VDBCLOUD_STEP_LIMIT

}  // namespace vdbcloud::sim
