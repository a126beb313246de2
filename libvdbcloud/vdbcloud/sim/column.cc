// The environment and the base state on the levels of a lattice.
#include "vdbcloud/sim/parameters.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

double interpolate(const std::vector<double>& z, const std::vector<double>& f, double at)
{
    if (at <= z.front()) return f.front();
    if (at >= z.back()) return f.back();
    const size_t i = size_t(std::upper_bound(z.begin(), z.end(), at) - z.begin());
    const double s = (at - z[i - 1]) / (z[i] - z[i - 1]);
    return f[i - 1] + s * (f[i] - f[i - 1]);
}

namespace {

/// The middle of the environment's theta_l, and the least q_t of the start, rounded to single precision so that a
/// deviation of 0 is exact.
Reference reference_of(const std::vector<Level>& levels, const Parameters& p)
{
    double low = never, high = -never, water = never;
    for (const Level& level : levels) {
        low = std::min(low, level.theta_env), high = std::max(high, level.theta_env);
        water = std::min(water, level.q_env);
    }
    if (!p.momentum) water = 0;  // a given wind may be divergent: there only q_t relative to 0 stays above 0
    water -= p.noise.water;
    for (const Bubble& b : p.bubbles) water += std::min(0.0, b.water);
    return {0.5 * (low + high), std::max(0.0, double(float(water)))};
}

}  // namespace

Column make_column(const Parameters& p, const Sounding& sounding)
{
    const Constants& c = p.constants;
    const int nz = p.lattice.n[2];
    const double dz = p.lattice.h[2], kappa = c.r_dry / c.cp;
    const double p0 = sounding.pressure > 0 ? sounding.pressure : c.surface_pressure;
    const double scale = p.q_scale_height > 0 ? p.q_scale_height : nz * dz / std::log(10.0);
    const auto at = [&](const std::vector<double>& f, double z) { return interpolate(sounding.z, f, z); };
    const auto theta_v = [&](double z) { return at(sounding.theta, z) * (1 + 0.608 * at(sounding.water, z)); };

    // A given wind is 0 towards walls: without momentum there is no pressure that could stop it.
    const auto windless = [&](int axis) {
        return p.lattice.flat(axis) || (!p.momentum && p.lattice.side[size_t(axis)] == Side::Wall);
    };
    // Exner function at half levels by the midpoint of fine sub-layers, so that it hardly depends on dz.
    Column column;
    column.floor_pressure = p0;
    double z = 0, exner = std::pow(p0 / 1e5, kappa);
    const double exner_floor = exner;
    const auto climb = [&](double to) {
        const int steps = std::max(1, int(std::ceil((to - z) / 10)));
        const double h = (to - z) / steps;
        for (int s = 0; s < steps; ++s) exner -= h * c.g / (c.cp * theta_v(z + (s + 0.5) * h));
        z = to;
    };
    const auto density = [&] { return std::pow(exner / exner_floor, 1 / kappa - 1) * theta_v(0) / theta_v(z); };
    const bool needs_pressure = p.anelastic || (p.moisture && p.moist.by == SaturationBy::Temperature);
    column.rho_face.push_back(1);
    for (int k = 0; k < nz; ++k) {
        climb((k + 0.5) * dz);
        if (needs_pressure && !(exner > 0.25)) {
            std::ostringstream text;
            text << "height of the box = " << nz * dz
                 << " m: expected a lid below the level of 1/100 of the surface pressure"
                 << " (or saturation by height, without anelastic)";
            throw InputError(text.str());
        }
        exner = std::max(exner, 0.25);
        Level level;
        level.z = z;
        level.exner = exner;
        level.pressure = 1e5 * std::pow(exner, 1 / kappa);
        level.q_height = p.q_surface * std::exp(-z / scale);
        level.heat = c.latent_heat / c.cp / (p.moist.by == SaturationBy::Temperature ? exner : 1);
        level.theta_env = at(sounding.theta, z);
        level.q_env = p.moisture ? at(sounding.water, z) : 0;
        column.level.push_back(level);
        column.u.push_back(windless(0) ? 0 : at(sounding.u, z) - p.frame[0]);
        column.v.push_back(windless(1) ? 0 : at(sounding.v, z) - p.frame[1]);
        column.rho_centre.push_back(p.anelastic ? density() : 1);
        climb((k + 1) * dz);
        exner = std::max(exner, 0.25);
        column.rho_face.push_back(p.anelastic ? density() : 1);
    }
    const Reference r = column.reference = reference_of(column.level, p);
    for (Level& level : column.level) level.theta_env -= r.theta, level.q_env -= r.water;
    return column;
}

}  // namespace vdbcloud::sim
