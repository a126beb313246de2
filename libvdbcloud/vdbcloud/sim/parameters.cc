#include "vdbcloud/sim/parameters.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/first_air.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

namespace {

void expect(const char* name, double value, const Range& range)
{
    if (!range.holds(value)) refuse(name, value, range.text());
}

void check_lattice(const Lattice& l)
{
    for (const size_t axis : {0, 1, 2}) {
        const std::string name(1, "xyz"[axis]);
        const int least = axis == 2 ? 2 : 1;
        if (l.n[axis] < least || l.n[axis] > 4096)
            refuse("cells along " + name, l.n[axis], axis == 2 ? "2..4096" : "1..4096");
        if (!(l.h[axis] >= 1e-3 && l.h[axis] <= 1e6)) refuse("spacing along " + name, l.h[axis], "1e-3..1e6 m");
    }
    if (l.cells() > (size_t(1) << 31)) refuse("number of cells", double(l.cells()), "up to 2^31");
}

/// `s` passed check_sounding().
void check_bubble(const Bubble& b, const Sounding& s)
{
    const auto coldest = std::min_element(s.theta.begin(), s.theta.end());
    for (const double place : b.centre) expect("bubble position", place, magnitude(1e9));
    expect("bubble radius", b.radius, {1e-3, 1e9});
    expect("bubble height", b.height, {1e-3, 1e9});
    expect("bubble temperature", b.theta, {std::max(-1000.0, allowed_theta.low - *coldest), 1000});
    expect("bubble water", b.water, magnitude(1));
    expect("bubble dye", b.dye, from_zero(1e6));
}

void check_sounding(const Sounding& s)
{
    const std::string name = s.name.empty() ? "sounding" : "sounding '" + printable(s.name) + "'";
    const size_t n = s.z.size();
    if (n == 0 || s.theta.size() != n || s.water.size() != n || s.u.size() != n || s.v.size() != n)
        throw InputError(name + ": expected a value of every column at every height");
    for (size_t i = 0; i < n; ++i) {
        if (!std::isfinite(s.z[i]) || (i > 0 && s.z[i] <= s.z[i - 1])) refuse(name + ": height", s.z[i], "increasing");
        if (!allowed_theta.holds(s.theta[i])) refuse(name + ": theta", s.theta[i], allowed_theta.text() + " K");
        if (!(s.water[i] >= 0 && s.water[i] <= 0.5)) refuse(name + ": water", s.water[i], "0..0.5 kg/kg");
        if (!(std::abs(s.u[i]) <= allowed_speed && std::abs(s.v[i]) <= allowed_speed))
            refuse(name + ": wind", std::hypot(s.u[i], s.v[i]), "up to 500 m/s");
    }
}

}  // namespace

int state_arrays(const Parameters& p) { return p.time_scheme == TimeScheme::Rk3 ? 4 : p.maccormack ? 3 : 2; }

double mixing_rate(const Parameters& p, double diffusivity)
{
    double inverse = 0;
    for (const size_t axis : {0, 1, 2})
        if (!p.lattice.flat(int(axis))) inverse += 1 / (p.lattice.h[axis] * p.lattice.h[axis]);
    // An Euler step of 1 / (2 k sum 1/h^2) takes all that a cell has; an eighth more of rate keeps away from that.
    return 9.0 / 4 * longest_stage(p.time_scheme) * diffusivity * inverse;
}

Sounding Sounding::uniform(double theta) { return {"uniform", {0}, {theta}, {0}, {0}, {0}, 0}; }

void check(const Parameters& p, const Sounding& sounding)
{
    check_lattice(p.lattice);
    check_sounding(sounding);
    for (const auto* group : {&constant_settings(), &noise_settings(), &numeric_settings()})
        for (const Setting& setting : *group) setting.check(p);
    for (const Effect& effect : effects()) {
        for (const Setting& setting : effect.settings) setting.check(p);
        if (effect.check) effect.check(p);
    }
    for (const Bubble& bubble : p.bubbles) check_bubble(bubble, sounding);
    if ((p.maccormack || p.fix_budget) && p.time_scheme != TimeScheme::HugeStep)
        throw InputError(
            "MacCormack's correction and the fix of budgets belong to huge steps: expected them, or neither");
    const bool open = p.lattice.side[0] == Side::Open || p.lattice.side[1] == Side::Open;
    if (p.fix_budget && open) throw InputError("a fix of budgets with open sides: expected periodic sides or walls");
    // Bubbles that are allowed alone may be too much together.
    FirstAir(p, make_column(p, sounding)).check_all();
}

double flux_end(const Parameters& p)
{
    return std::isfinite(p.floor.until) ? p.floor.until - 1e-9 * std::max(1.0, p.floor.until) : never;
}

double fastest_rate(const Parameters& p)
{
    double rate = 0;
    for (const Effect& effect : effects())
        if (effect.fastest_rate && effect.on(p)) rate = std::max(rate, effect.fastest_rate(p));
    return rate;
}

double step_limit(const Parameters& p, double courant_rate, double frequency)
{
    // Advection and mixing share one step: their rates add, for stability and so that sums of a stage stay convex.
    const double shared = longest_stage(p.time_scheme) * courant_rate / p.cfl + fastest_rate(p);
    double limit = p.dt_max;
    if (shared > 0) limit = std::min(limit, (p.subgrid ? 0.7 : 1) / shared);
    if (frequency > 0) limit = std::min(limit, 0.5 / frequency);
    return limit;
}

double frequency_of(const Parameters& p, const Column& column)
{
    double steepest = 0;
    if (p.buoyancy)
        for (size_t k = 1; k < column.level.size(); ++k)
            steepest = std::max(steepest, std::abs(column.level[k].theta_env - column.level[k - 1].theta_env));
    return std::sqrt(p.constants.g / p.constants.theta0 * steepest / p.lattice.h[2]);
}

double courant_rate_of(const Parameters& p, const Column& column)
{
    double rate = 0;
    for (size_t k = 0; k < column.u.size(); ++k)
        rate = std::max(rate, std::abs(column.u[k]) / p.lattice.h[0] + std::abs(column.v[k]) / p.lattice.h[1]);
    return rate;
}

size_t memory_needed(const Parameters& p)
{
    const Lattice& l = p.lattice;
    const size_t value = p.precision == Precision::Float ? 4 : 8;
    const auto padded = [&](int axis, int more) { return size_t(l.n[size_t(axis)] + (l.flat(axis) ? 0 : more)); };
    const size_t field = (padded(0, 12) + 7) / 8 * 8 * padded(1, 8) * padded(2, 8) * value;
    const size_t planes = size_t(l.n[0] + 2) * size_t(l.n[1]) * size_t(l.n[2]) * value;
    const int velocities = 1 + !l.flat(0) + !l.flat(1);
    int fields = 1 + velocities * (p.momentum ? state_arrays(p) : 1);  // 1: drain times
    if (p.buoyancy || p.moisture) fields += state_arrays(p);
    for (const Effect& effect : effects())
        if (effect.fields && effect.on(p)) fields += effect.fields(p);
    return size_t(fields) * field + (p.momentum ? planes : 0);
}

}  // namespace vdbcloud::sim
