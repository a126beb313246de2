// The Coriolis force on the wind less its geostrophic part, which the large-scale pressure gradient balances:
//
//     du/dt = f (v - v_g),   dv/dt = -f (u - u_g)
#include "vdbcloud/sim/cross_wind.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Geostrophic wind of each level over the ground along an axis [m/s]: the large-scale forcing's, else the sounding's.
template<typename T>
std::vector<T> geostrophic_wind(const Air<T>& air, int axis)
{
    const LargeScale& given = air.parameters.large_scale;
    const std::vector<double>& column = axis == 0 ? given.u_g : given.v_g;
    std::vector<T> wind;
    for (size_t k = 0; k < air.column.level.size(); ++k)
        wind.push_back(T(!column.empty() ? interpolate(given.z, column, air.column.level[k].z)
                                         : (axis == 0 ? air.column.u[k] : air.column.v[k]) +
                                               air.reference(air.wind[size_t(axis)].quantity)));
    return wind;
}

template<typename T>
void add(Air<T>& air)
{
    for (const int axis : {0, 1}) {
        const T f = T(axis == 0 ? air.parameters.coriolis : -air.parameters.coriolis);
        Variable<T>& v = air.wind[size_t(axis)];
        v.terms.push_back(
            [&air, &v, axis, f, balanced = geostrophic_wind(air, 1 - axis)](int in, int j, int k, T* out) {
                const CrossWind<T> other(air, axis, in, j, k);
                const T rest = balanced[size_t(k)];
                for (int i = air.first_free(v, j); i < air.width(v); ++i) out[i] += f * (other.at(i) - rest);
            });
    }
}

}  // namespace

Effect coriolis()
{
    Effect effect{"Coriolis force",
                  "",
                  {{"coriolis", "Coriolis parameter f of the wind less its geostrophic part; 0 is off", "1/s",
                    magnitude(1), [](Parameters& p) -> double& { return p.coriolis; }}},
                  [](const Parameters& p) { return p.coriolis != 0; },
                  [](const Parameters& p) {
                      if (p.coriolis != 0 && !p.momentum)
                          throw InputError("Coriolis force on a given wind: expected momentum, or coriolis 0");
                      if (p.coriolis != 0 && (p.lattice.flat(0) || p.lattice.flat(1)))
                          throw InputError(
                              "Coriolis force in a slice, which has no wind across: expected two cells or more along x "
                              "and y, or coriolis 0");
                  },
                  nullptr,
                  {add<float>, add<double>}};
    effect.fastest_rate = [](const Parameters& p) { return 2 * std::abs(p.coriolis); };
    return changeable(effect);
}

}  // namespace vdbcloud::sim::effect
