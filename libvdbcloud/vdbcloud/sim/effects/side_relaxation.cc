// Near open sides everything returns to the environment, so that what leaves is not seen again.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

bool open(const Parameters& p) { return p.lattice.side[0] == Side::Open || p.lattice.side[1] == Side::Open; }

/// cos^2 of the distance from the nearer open end of an axis, 1 there and 0 from `depth` cells on; `position` in cells
/// from the lower end.
double weight(const Lattice& lattice, double depth, int axis, double position)
{
    const int n = lattice.n[size_t(axis)];
    if (lattice.side[size_t(axis)] != Side::Open || lattice.flat(axis)) return 0;
    const double inside = std::min(position, n - position);
    return inside >= depth ? 0.0 : std::pow(std::cos(pi / 2 * inside / depth), 2);
}

/// dq/dt = -weight / time (q - environment(level)).
template<typename T>
void relax(Air<T>& air, Variable<T>& v)
{
    const Parameters& p = air.parameters;
    const double shift_x = v.place == Place::FaceX ? 0 : 0.5, shift_y = v.place == Place::FaceY ? 0 : 0.5;
    const int width = air.width(v), rows = air.rows(v);
    std::vector<double> rate;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < width; ++i)
            rate.push_back(std::max(weight(air.lattice, p.side_cells, 0, i + shift_x),
                                    weight(air.lattice, p.side_cells, 1, j + shift_y)) /
                           p.side_relaxation);
    air.relax(v).set_columns(rate);
}

template<typename T>
void add(Air<T>& air)
{
    if (air.parameters.side_cells <= 0) return;
    if (air.parameters.momentum)
        for (Variable<T>* v : air.velocities()) relax(air, *v);
    for (Variable<T>* v : air.scalars()) relax(air, *v);
}

}  // namespace

Effect side_relaxation()
{
    return changeable(
        {"open sides",
         "",
         {Setting::time("side-relaxation", "time in which air at open sides returns to the sounding's",
                        {0, any_finite, true}, [](Parameters& p) -> double& { return p.side_relaxation; }),
          {"side-depth", "cells from open sides within which air returns to the sounding's; 0 is off", "",
           from_zero(1000), [](Parameters& p) -> double& { return p.side_cells; }}},
         open,
         nullptr,
         nullptr,
         {add<float>, add<double>},
         0,
         "sides open"});
}

}  // namespace vdbcloud::sim::effect
