// Molecular mixing: Laplacians with constant coefficients, of the wind (viscosity) and of scalars (diffusion).
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/rows.h"

namespace vdbcloud::sim::effect {

namespace {

/// dq/dt = k lap q on the second-order stencil, nothing along flat axes.
template<typename T>
void add_mixing(Air<T>& air, Variable<T>& v, double k)
{
    const auto coefficient = [&](int axis) {
        return T(air.lattice.flat(axis) ? 0 : k / (air.lattice.h[size_t(axis)] * air.lattice.h[size_t(axis)]));
    };
    v.stiff.push_back([&v, width = air.width(v), cx = coefficient(0), cy = coefficient(1),
                       cz = coefficient(2)](int in, int j, int level, T* out) {
        const Field<T>& q = v.a[size_t(in)];
        add_laplacian({q.row(j, level), cx == 0 ? 0 : 1, cy == 0 ? 0 : q.stride(1), q.stride(2), cx, cy, cz}, out,
                      width);
    });
}

template<typename T>
void add_viscosity(Air<T>& air)
{
    const double nu = air.parameters.viscosity;
    if (air.parameters.momentum)
        for (Variable<T>* v : air.velocities()) add_mixing(air, *v, nu);
}

template<typename T>
void add_diffusion(Air<T>& air)
{
    const double kappa = air.parameters.diffusivity;
    for (Variable<T>* v : air.scalars()) add_mixing(air, *v, kappa);
}

}  // namespace

Effect viscosity()
{
    Effect effect{"viscosity",
                  "a Laplacian of u, v, w",
                  {{"viscosity", "kinematic viscosity of the air", "m^2/s", from_zero(1e6),
                    [](Parameters& p) -> double& { return p.viscosity; }}},
                  [](const Parameters& p) { return p.viscosity > 0; },
                  nullptr,
                  nullptr,
                  {add_viscosity<float>, add_viscosity<double>}};
    effect.fastest_rate = [](const Parameters& p) { return mixing_rate(p, p.viscosity); };
    return changeable(effect);
}

Effect diffusion()
{
    Effect effect{"diffusion",
                  "a Laplacian of every scalar",
                  {{"diffusivity", "diffusivity of heat, water and dye", "m^2/s", from_zero(1e6),
                    [](Parameters& p) -> double& { return p.diffusivity; }}},
                  [](const Parameters& p) { return p.diffusivity > 0; },
                  nullptr,
                  nullptr,
                  {add_diffusion<float>, add_diffusion<double>}};
    effect.fastest_rate = [](const Parameters& p) { return mixing_rate(p, p.diffusivity); };
    return changeable(effect);
}

}  // namespace vdbcloud::sim::effect
