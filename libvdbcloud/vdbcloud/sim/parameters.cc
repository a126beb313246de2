#include "vdbcloud/sim/parameters.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

namespace {

[[noreturn]] void refuse(const std::string& name, double value, const char* expected)
{
    std::ostringstream text;
    text << name << " = " << value << ": expected " << expected;
    throw InputError(text.str());
}

void expect_positive(const char* name, double value)
{
    if (!(value > 0)) refuse(name, value, "above 0");
}
void expect_finite_positive(const char* name, double value)
{
    if (!(value > 0 && std::isfinite(value))) refuse(name, value, "finite and above 0");
}
void expect_from_zero(const char* name, double value)
{
    if (!(value >= 0 && std::isfinite(value))) refuse(name, value, "finite, 0 or above");
}
void expect_finite(const char* name, double value)
{
    if (!std::isfinite(value)) refuse(name, value, "a finite number");
}
/// Sizes that no weather has, so that arithmetic in single precision stays far from its end.
void expect_within(const char* name, double value, double most)
{
    if (!(std::abs(value) <= most)) {
        std::ostringstream text;
        text << "of magnitude up to " << most;
        refuse(name, value, text.str().c_str());
    }
}

double interpolate(const std::vector<double>& z, const std::vector<double>& f, double at)
{
    if (at <= z.front()) return f.front();
    if (at >= z.back()) return f.back();
    const size_t i = size_t(std::upper_bound(z.begin(), z.end(), at) - z.begin());
    const double s = (at - z[i - 1]) / (z[i] - z[i - 1]);
    return f[i - 1] + s * (f[i] - f[i - 1]);
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

void check_forcing(const Parameters& p)
{
    const Floor& f = p.floor;
    expect_within("floor heat flux", f.heat, 1e3);
    expect_from_zero("floor moisture flux", f.moisture);
    expect_within("floor moisture flux", f.moisture, 1);
    if (!(f.until >= 0)) refuse("end of the floor's fluxes", f.until, "0 or above");
    for (const Patch& patch : f.patches) {
        expect_finite("patch position", patch.centre[0] + patch.centre[1]);
        expect_finite_positive("patch radius", patch.radius);
        expect_within("patch heat flux", patch.heat, 1e3);
        expect_from_zero("patch moisture flux", patch.moisture);
        expect_within("patch moisture flux", patch.moisture, 1);
        expect_from_zero("patch dye flux", patch.dye);
        expect_within("patch dye flux", patch.dye, 1e6);
    }
    if (!f.map.empty() && f.map.size() != size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]))
        refuse("cells of the floor's map", double(f.map.size()), "one a column of the box");
    for (const double factor : f.map) expect_from_zero("factor of the floor's map", factor);
    for (const Bubble& b : p.bubbles) {
        expect_finite("bubble position", b.centre[0] + b.centre[1] + b.centre[2]);
        expect_finite_positive("bubble radius", b.radius);
        expect_finite_positive("bubble height", b.height);
        expect_within("bubble temperature", b.theta, 1000);
        expect_within("bubble water", b.water, 1);
        expect_from_zero("bubble dye", b.dye);
    }
    expect_from_zero("noise of theta", p.noise.theta);
    expect_within("noise of theta", p.noise.theta, 100);
    expect_from_zero("noise of water", p.noise.water);
    expect_within("noise of water", p.noise.water, 0.1);
}

void check_sounding(const Sounding& s)
{
    const std::string name = s.name.empty() ? "sounding" : "sounding '" + printable(s.name) + "'";
    const size_t n = s.z.size();
    if (n == 0 || s.theta.size() != n || s.water.size() != n || s.u.size() != n || s.v.size() != n)
        throw InputError(name + ": expected a value of every column at every height");
    for (size_t i = 0; i < n; ++i) {
        if (!std::isfinite(s.z[i]) || (i > 0 && s.z[i] <= s.z[i - 1])) refuse(name + ": height", s.z[i], "increasing");
        if (!(s.theta[i] >= 100 && s.theta[i] <= 2000)) refuse(name + ": theta", s.theta[i], "100..2000 K");
        if (!(s.water[i] >= 0 && s.water[i] <= 0.5)) refuse(name + ": water", s.water[i], "0..0.5 kg/kg");
        if (!(std::abs(s.u[i]) <= 500 && std::abs(s.v[i]) <= 500))
            refuse(name + ": wind", std::hypot(s.u[i], s.v[i]), "up to 500 m/s");
    }
}

/// The middle of the environment's theta_l, and water that is everywhere at the start: exact in single precision, so
/// that none is none.
Reference reference_of(const std::vector<Level>& levels, const Parameters& p)
{
    double low = never, high = -never, water = never;
    for (const Level& level : levels) {
        low = std::min(low, level.theta_env), high = std::max(high, level.theta_env);
        water = std::min(water, level.q_env);
    }
    if (!p.momentum) water = 0;  // a given wind may converge: what is counted from 0 stays above it even there
    water -= p.noise.water;
    for (const Bubble& b : p.bubbles) water += std::min(0.0, b.water);
    return {0.5 * (low + high), std::max(0.0, double(float(water)))};
}

}  // namespace

int state_arrays(const Parameters& p) { return p.time_scheme == TimeScheme::Rk3 || p.maccormack ? 3 : 2; }

Sounding Sounding::uniform(double theta) { return {"uniform", {0}, {theta}, {0}, {0}, {0}, 0}; }

void check(const Parameters& p, const Sounding& sounding)
{
    check_lattice(p.lattice);
    check_sounding(sounding);
    const Constants& c = p.constants;
    expect_from_zero("g", c.g), expect_within("g", c.g, 1000);
    expect_finite_positive("theta0", c.theta0), expect_within("theta0", c.theta0, 1e4);
    expect_from_zero("latent heat", c.latent_heat), expect_within("latent heat", c.latent_heat, 1e8);
    expect_finite_positive("cp", c.cp), expect_within("cp", 1 / c.cp, 1);
    expect_finite_positive("gas constant of dry air", c.r_dry);
    expect_finite_positive("gas constant of vapour", c.r_vapour);
    expect_finite_positive("surface pressure", c.surface_pressure);
    expect_finite_positive("rho0", c.rho0);
    expect_finite_positive("A of saturation", p.q_surface), expect_within("A of saturation", p.q_surface, 1);
    expect_from_zero("scale height of saturation", p.q_scale_height);
    expect_positive("friction time", p.friction_time);
    expect_positive("wind relaxation time", p.wind_relaxation);
    expect_finite_positive("relaxation time of open sides", p.side_relaxation);
    if (p.side_cells < 0) refuse("cells of open sides", p.side_cells, "0 or more");
    expect_from_zero("viscosity", p.viscosity), expect_within("viscosity", p.viscosity, 1e6);
    expect_from_zero("diffusivity", p.diffusivity), expect_within("diffusivity", p.diffusivity, 1e6);
    expect_from_zero("Smagorinsky coefficient", p.smagorinsky),
        expect_within("Smagorinsky coefficient", p.smagorinsky, 10);
    expect_from_zero("radiative flux", p.radiation), expect_within("radiative flux", p.radiation, 1e5);
    expect_from_zero("absorption of radiation", p.radiation_kappa);
    expect_from_zero("sponge rate", p.sponge), expect_within("sponge rate", p.sponge, 1e3);
    if (!(p.sponge_depth > 0 && p.sponge_depth <= 1)) refuse("sponge depth", p.sponge_depth, "a fraction in (0, 1]");
    if (!(p.cfl > 0 && p.cfl <= 0.75)) refuse("Courant number", p.cfl, "in (0, 0.75]");
    expect_from_zero("time step", p.dt);
    expect_finite_positive("longest time step", p.dt_max);
    const bool open = p.lattice.side[0] == Side::Open || p.lattice.side[1] == Side::Open;
    if ((p.maccormack || p.fix_budget) && p.time_scheme != TimeScheme::HugeStep)
        throw InputError(
            "MacCormack's correction and the fix of budgets belong to huge steps: expected them, or neither");
    if (p.fix_budget && open) throw InputError("a fix of budgets with open sides: expected periodic sides or walls");
    if (p.rain && !p.moisture) throw InputError("rain without moisture: expected moisture, or no rain");
    if (p.radiation > 0 && !p.moisture) throw InputError("radiation of cloud without moisture: expected moisture");
    check_forcing(p);
}

Column make_column(const Parameters& p, const Sounding& sounding)
{
    const Constants& c = p.constants;
    const int nz = p.lattice.n[2];
    const double dz = p.lattice.h[2], kappa = c.r_dry / c.cp;
    const double p0 = sounding.pressure > 0 ? sounding.pressure : c.surface_pressure;
    const double scale = p.q_scale_height > 0 ? p.q_scale_height : nz * dz / std::log(10.0);
    const auto at = [&](const std::vector<double>& f, double z) { return interpolate(sounding.z, f, z); };
    const auto theta_v = [&](double z) { return at(sounding.theta, z) * (1 + 0.608 * at(sounding.water, z)); };

    // Without momentum there is no pressure that could stop a wind at walls.
    const auto windless = [&](int axis) {
        return p.lattice.flat(axis) || (!p.momentum && p.lattice.side[size_t(axis)] == Side::Wall);
    };
    // Exner function at half levels by the midpoint of fine sub-layers, so that it hardly depends on dz.
    Column column;
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
            text << "height of the box = " << nz * dz << " m: expected the lid below 1/100 of the surface pressure"
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
        column.u.push_back(windless(0) ? 0 : at(sounding.u, z));
        column.v.push_back(windless(1) ? 0 : at(sounding.v, z));
        column.rho_centre.push_back(p.anelastic ? density() : 1);
        climb((k + 1) * dz);
        exner = std::max(exner, 0.25);
        column.rho_face.push_back(p.anelastic ? density() : 1);
    }
    const Reference r = column.reference = reference_of(column.level, p);
    for (Level& level : column.level) level.theta_env -= r.theta, level.q_env -= r.water;
    return column;
}

std::vector<Effect> effects(const Parameters& p)
{
    const auto list = [](bool on, const char* what) { return on ? what : ""; };
    const bool open = p.lattice.side[0] == Side::Open || p.lattice.side[1] == Side::Open;
    return {
        {"momentum and pressure", p.momentum, list(p.momentum, "u, v, w with stages, pressure, transforms")},
        {"buoyancy", p.buoyancy, list(p.buoyancy, "theta_l with stages")},
        {"moisture", p.moisture, list(p.moisture, "q_t with stages, condensation")},
        {"latent heat", p.moisture && p.moist.latent_heat, ""},
        {"vapour in buoyancy", p.moisture && p.moist.vapour, ""},
        {"cloud water in buoyancy", p.moisture && p.moist.loading, ""},
        {"rain", p.rain, list(p.rain, "q_r with stages, conversion and fall")},
        {"dye", p.dye, list(p.dye, "dye with stages")},
        {"friction", std::isfinite(p.friction_time), ""},
        {"viscosity", p.viscosity > 0, list(p.viscosity > 0, "a Laplacian of u, v, w")},
        {"diffusion", p.diffusivity > 0, list(p.diffusivity > 0, "a Laplacian of every scalar")},
        {"sub-grid mixing", p.subgrid, list(p.subgrid, "eddy viscosity, strain")},
        {"radiation", p.radiation > 0, list(p.radiation > 0, "heating rate, column sums")},
        {"sponge", p.sponge > 0, ""},
        {"wind relaxation", std::isfinite(p.wind_relaxation), list(std::isfinite(p.wind_relaxation), "level means")},
        {"open sides", open, ""},
        {"anelastic base state", p.anelastic, list(p.anelastic, "a profile")},
    };
}

size_t memory_needed(const Parameters& p)
{
    const Lattice& l = p.lattice;
    const size_t value = p.precision == Precision::Float ? 4 : 8;
    const auto padded = [&](int axis, int more) { return size_t(l.n[size_t(axis)] + (l.flat(axis) ? 0 : more)); };
    const size_t field = (padded(0, 12) + 7) / 8 * 8 * padded(1, 8) * padded(2, 8) * value;
    const size_t planes = size_t(l.n[0] + 2) * size_t(l.n[1]) * size_t(l.n[2]) * value;
    const int stages = state_arrays(p);
    const int velocities = 1 + !l.flat(0) + !l.flat(1);
    const bool warm = p.buoyancy || p.moisture;
    int fields = velocities * (p.momentum ? stages : 1);
    fields += stages * (warm + p.moisture + p.rain + p.dye);
    fields += 1 + p.subgrid + (p.radiation > 0);  // drain times
    return size_t(fields) * field + (p.momentum ? planes : 0);
}

}  // namespace vdbcloud::sim
