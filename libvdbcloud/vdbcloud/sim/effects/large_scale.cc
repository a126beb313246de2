// What weather of larger scale than the box does to the air of each level: subsidence, dq/dt = -w dq/dz of every
// quantity, and prescribed tendencies of theta_l and q_t.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// Values of a column at the levels of the air, times `factor`.
template<typename T>
std::vector<T> at_levels(const Air<T>& air, const std::vector<double>& column, double factor = 1)
{
    std::vector<T> values;
    for (const Level& level : air.column.level)
        values.push_back(T(factor * interpolate(air.parameters.large_scale.z, column, level.z)));
    return values;
}

/// Upwind differences: the air of a level comes from the level above where air sinks, from below where it rises. Beyond
/// floor and lid the quantity continues with the environment's own gradient.
template<typename T>
void add_subsidence(Air<T>& air, Variable<T>& v, const std::vector<T>& sinking)
{
    const std::vector<double> environment = air.environment(v.quantity);
    const int last = air.lattice.n[2] - 1;
    const T at_floor = T(environment[1] - environment[0]),
            at_lid = T(environment[size_t(last)] - environment[size_t(last) - 1]);
    v.terms.push_back([&v, sinking, at_floor, at_lid, last, &air](int in, int j, int k, T* out) {
        const T rate = sinking[size_t(k)];
        const Field<T>& field = v.a[size_t(in)];
        const bool sinks = rate > 0, beyond = k == (sinks ? last : 0);
        if (rate == 0) return;
        if (beyond) {
            for (int i = air.first_free(v, j); i < air.width(v); ++i) out[i] += rate * (sinks ? at_lid : at_floor);
            return;
        }
        const T *upper = field.row(j, sinks ? k + 1 : k), *lower = field.row(j, sinks ? k : k - 1);
        for (int i = 0; i < air.width(v); ++i) out[i] += rate * (upper[i] - lower[i]);
    });
}

template<typename T>
void add_all_subsidence(Air<T>& air)
{
    const std::vector<T> sinking = at_levels(air, air.parameters.large_scale.w, -1 / air.lattice.h[2]);
    for (Variable<T>* v : {&air.theta, &air.water, &air.dye})
        if (*v) add_subsidence(air, *v, sinking);
    if (!air.parameters.momentum || !air.parameters.large_scale.carries_wind) return;
    for (const size_t axis : {0, 1})
        if (air.wind[axis]) add_subsidence(air, air.wind[axis], sinking);
}

template<typename T>
void add_tendencies(Air<T>& air)
{
    const auto tend = [&](Variable<T>& v, const std::vector<double>& column) {
        if (!v || column.empty()) return;
        v.terms.push_back([rates = at_levels(air, column), n = air.lattice.n[0]](int, int, int k, T* out) {
            for (int i = 0; i < n; ++i) out[i] += rates[size_t(k)];
        });
    };
    tend(air.theta, air.parameters.large_scale.theta);
    tend(air.water, air.parameters.large_scale.water);
}

void check(const Parameters& p)
{
    const LargeScale& f = p.large_scale;
    const std::string name = f.name.empty() ? "forcing" : "forcing '" + printable(f.name) + "'";
    for (size_t i = 0; i < f.z.size(); ++i)
        if (!std::isfinite(f.z[i]) || (i > 0 && f.z[i] <= f.z[i - 1])) refuse(name + ": height", f.z[i], "increasing");
    const auto expect = [&](const std::vector<double>& column, const char* what, double most, const char* unit) {
        if (!column.empty() && column.size() != f.z.size())
            throw InputError(name + ": expected a value of " + what + " at every height");
        for (const double value : column)
            if (!magnitude(most).holds(value)) refuse(name + ": " + what, value, magnitude(most).text() + " " + unit);
    };
    expect(f.w, "w_ls", 10, "m/s"), expect(f.u_g, "u_g", allowed_speed, "m/s"),
        expect(f.v_g, "v_g", allowed_speed, "m/s");
    expect(f.theta, "dtheta_l", 1, "K/s"), expect(f.water, "dq_t", 1e-3, "1/s");
    if (f.u_g.empty() != f.v_g.empty()) throw InputError(name + ": expected both u_g and v_g, or neither");
}

bool subsides(const Parameters& p) { return !p.large_scale.w.empty(); }

/// Subsidence shares a step with transport and mixing, whose bounds it tightens.
double subsidence_rate(const Parameters& p)
{
    double fastest = 0;
    for (const double w : p.large_scale.w) fastest = std::max(fastest, std::abs(w));
    return longest_stage(p.time_scheme) * fastest / p.lattice.h[2] / p.cfl +
           mixing_rate(p, std::max(p.viscosity, p.diffusivity));
}

}  // namespace

Effect subsidence()
{
    Effect effect{"subsidence",
                  "",
                  {{"subsidence-of-wind", "subsidence carries the wind, too, not heat and water alone",
                    [](Parameters& p) -> bool& { return p.large_scale.carries_wind; }}},
                  subsides,
                  check,
                  nullptr,
                  {add_all_subsidence<float>, add_all_subsidence<double>},
                  0,
                  "forcing of a table with w_ls"};
    effect.fastest_rate = subsidence_rate;
    return changeable(effect);
}

Effect large_scale_tendencies()
{
    return changeable({"large-scale tendencies",
                       "",
                       {},
                       [](const Parameters& p) { return !p.large_scale.theta.empty() || !p.large_scale.water.empty(); },
                       nullptr,
                       nullptr,
                       {add_tendencies<float>, add_tendencies<double>},
                       0,
                       "forcing of a table with dtheta_l or dq_t"});
}

}  // namespace vdbcloud::sim::effect
