#pragma once
// The parameters of a simulation: SI units, z up, x and y along the floor, the origin at a lower corner.
#include "vdbcloud/sim/field.h"
#include "vdbcloud/sim/rows.h"
#include "vdbcloud/sim/shape.h"
#include "vdbcloud/sim/thermodynamics.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace vdbcloud::sim {

inline constexpr double never = std::numeric_limits<double>::infinity();

enum class Precision { Float, Double };
enum class TimeScheme {
    Euler,  ///< forward differencing, first order
    Rk2,    ///< Heun, strong stability preserving, second order
    Rk3,    ///< third order, strong stability preserving, of four stages that never go back in time (Isherwood et al.
            ///< 2018)
    HugeStep,  ///< semi-Lagrangian, stable at any step, first order, conserves nothing (Stam 1999)
};

/// A warm or moist ellipsoid in the initial air: amplitude times cos^2(pi/2 r), r the normalised distance from its
/// centre.
struct Bubble {
    std::array<double, 3> centre{0, 0, 0};  ///< [m]
    double radius = 500;                    ///< horizontal [m], > 0
    double height = 500;                    ///< vertical half axis [m], > 0
    double theta = 0;                       ///< [K]
    double water = 0;                       ///< [kg/kg]
    double dye = 0;
};

/// A round patch of floor with Gaussian fluxes of heat, water and dye.
struct Patch {
    std::array<double, 2> centre{0, 0};  ///< [m]
    double radius = 500;                 ///< where the flux has fallen to 1/e [m], > 0
    double heat = 0;                     ///< kinematic heat flux at the centre [K m/s]
    double moisture = 0;                 ///< [kg/kg m/s], >= 0
    double dye = 0;                      ///< [1/s m], >= 0
    double fuel = 0;                     ///< [1/s m], >= 0
};

struct Floor {
    double heat = 0;       ///< uniform kinematic heat flux [K m/s]
    double moisture = 0;   ///< uniform [kg/kg m/s], >= 0
    double until = never;  ///< fluxes stop then [s]
    std::vector<Patch> patches;
    std::vector<double> map;  ///< empty, or a factor for the uniform fluxes, one a cell of the floor, x fastest, >= 0
};

/// Fuel that the air carries, 1 for gas that is fuel alone, and that turns to heat and soot: see effects/combustion.cc.
struct Combustion {
    bool on = false;
    double time = 0.2;      ///< in which fuel burns to 1/e [s]
    double heat = 4000;     ///< warming of air by all of its fuel 1 [K]
    double soot = 1;        ///< dye that fuel 1 leaves
    double ignition = 500;  ///< fuel burns above this temperature [K]
    double flame = 1900;    ///< no burning heats air above this temperature [K]
};

struct Noise {
    double theta = 0;      ///< amplitude of uniform noise on theta_l [K]
    double water = 0;      ///< on q_t [kg/kg]
    double below = never;  ///< only below this height [m]
    uint64_t seed = 1;
};

/// Large-scale forcing by height: linear between the given heights, constant beyond them. An empty column does not act.
struct LargeScale {
    std::string name;
    std::vector<double> z;         ///< [m], increasing
    std::vector<double> w;         ///< mean vertical wind, negative where air subsides [m/s]
    std::vector<double> u_g, v_g;  ///< geostrophic wind [m/s]; empty: the sounding's wind
    std::vector<double> theta;     ///< tendency of theta_l [K/s]
    std::vector<double> water;     ///< tendency of q_t [1/s]
    bool carries_wind = true;      ///< subsidence acts on u and v, too
};

/// The lowest cells against the surface. Coefficients hold for the height of the lowest cell centre.
struct Surface {
    double friction_velocity = 0;  ///< u* of a stress u*^2 against the wind [m/s]
    double drag = 0;               ///< C_m of a stress C_m |V|^2 against the wind
    double heat_exchange = 0;      ///< C_h of a heat flux C_h |V| (theta_surface - theta_l)
    double water_exchange = 0;     ///< C_q of a water flux C_q |V| (q_s(surface) - q_t)
    double temperature = 300;      ///< of the surface [K]
};

struct Parameters {
    Lattice lattice{{128, 128, 128}, {32, 32, 32}, {Side::Periodic, Side::Periodic}};
    Precision precision = Precision::Float;

    // Effects: see effects/. An effect that is off allocates no field and runs no kernel.
    bool momentum = true;  ///< off: the environment's wind blows for ever, but not at walls (no momentum, no pressure)
    bool buoyancy = true;
    bool moisture = true;
    bool rain = false;       ///< Kessler 1969: autoconversion, accretion, evaporation, fall
    double droplets = 0;     ///< of cloud, in a cm^3: conversion to rain as Khairoutdinov and Kogan 2000; 0: Kessler's
    bool anelastic = false;  ///< density of the base state falls with height
    bool dye = false;        ///< a passive scalar, e.g. smoke
    bool subgrid = false;    ///< Smagorinsky-Lilly
    Combustion combustion;
    double cooling = 0;                 ///< of air at cooling_temperature by radiation [K/s]; falls with the 4th power
    double cooling_temperature = 1900;  ///< [K]
    std::array<double, 2> frame{0, 0};  ///< velocity of the box over the ground [m/s]
    MoistTerms moist;
    double friction_time = never;  ///< drag -V/t_f [s], > 0
    double viscosity = 0;          ///< [m^2/s]
    double diffusivity = 0;        ///< of theta_l, q_t, dye [m^2/s]
    double smagorinsky = 0.17;
    double radiation = 0;            ///< long-wave cooling of cloud top: net flux lost to space [W/m^2]; 70 is usual
    double radiation_kappa = 85;     ///< its absorption by cloud water [m^2/kg]
    double sponge = 0;               ///< damping at the lid [1/s], sin^2 from sponge_depth below it
    double sponge_depth = 0.2;       ///< fraction of the height
    double wind_relaxation = never;  ///< horizontal mean wind returns to the environment's in this time [s]
    double side_relaxation = 60;     ///< open sides: return to the environment in this time [s] ...
    double side_cells = 6;           ///< ... within so many cells of them

    Constants constants;
    double q_surface = 0.02;    ///< A of q_s = A exp(-z/H) [kg/kg]
    double q_scale_height = 0;  ///< H [m]; 0: height of the box / ln 10, the paper's rule

    Floor floor;
    Surface surface;
    LargeScale large_scale;
    double coriolis = 0;  ///< Coriolis parameter f [1/s]
    std::vector<FieldSource> sources;
    std::vector<std::shared_ptr<const Shape>> colliders;  ///< bodies that air flows around
    std::vector<Bubble> bubbles;
    Noise noise;

    // Numerics.
    TimeScheme time_scheme = TimeScheme::Rk3;
    ScalarScheme scalar_scheme = ScalarScheme::Limited5;
    MomentumScheme momentum_scheme = MomentumScheme::Upwind5;
    /// Bound of tau dt (|u|/dx + |v|/dy + |w|/dz), which sets the step; tau dt is the length of the Euler steps that
    /// stages are sums of (longest_stage()): 1.2 cells a step of Rk3 at the default. Steps are stable and bounded up to
    /// 0.75. Limited scalars diffuse more in long steps where the air is fastest: a stage keeps min(1, 1 / cfl - 1) of
    /// the slope behind the donor, all of it at 0.5, half at 2/3, a third at 0.75.
    double cfl = 2.0 / 3;
    bool maccormack = false;  ///< huge steps: second order in space, for twice the time
    bool fix_budget = false;  ///< huge steps: all cells share the heat, water and dye that transport lost
    double dt = 0;            ///< wanted step [s]; split where it exceeds a limit; 0: the longest that the limits allow
    double dt_max = 60;       ///< longest step [s]
};

/// The air at the start by height: linear between the given heights, constant beyond them.
struct Sounding {
    std::string name;
    std::vector<double> z;      ///< [m], increasing
    std::vector<double> theta;  ///< liquid water potential temperature [K]
    std::vector<double> water;  ///< total water [kg/kg]
    std::vector<double> u, v;   ///< wind [m/s]
    double pressure = 0;        ///< at the floor [Pa]; 0: as the constants say

    static Sounding uniform(double theta);
};

/// The environment and the base state on the levels of a lattice.
struct Column {
    Reference reference;                       ///< what theta_l and q_t of fields and levels are relative to
    std::vector<Level> level;                  ///< nz, at cell centres
    std::vector<double> u, v;                  ///< nz, relative to the box [m/s]
    std::vector<double> rho_centre, rho_face;  ///< relative to the floor; 1 unless anelastic
    double floor_pressure = 1e5;               ///< [Pa]
};

/// The value at a height of a column f given at heights z: linear between them, constant beyond them.
double interpolate(const std::vector<double>& z, const std::vector<double>& f, double at);

/// Throws InputError that names the first value out of its range.
void check(const Parameters&, const Sounding&);

/// Hydrostatic base state: d(exner)/dz = -g / (cp theta_v). Throws InputError if the box reaches above the atmosphere.
Column make_column(const Parameters&, const Sounding&);

/// When the fluxes through the floor end [s]: --flux-until, less what rounding may leave of the time of a step.
double flux_end(const Parameters&);
/// The rate [1/s] of explicit mixing by a diffusivity [m^2/s].
double mixing_rate(const Parameters&, double diffusivity);
/// The largest rate of explicit mixing [1/s]: a step times this rate must stay below 1.
double fastest_rate(const Parameters&);
/// The longest step of the conservative schemes [s], in air whose largest sum of |velocity| / spacing is
/// `courant_rate` [1/s] and whose largest buoyancy frequency is `frequency` [1/s].
double step_limit(const Parameters&, double courant_rate, double frequency);
/// The largest buoyancy frequency of the environment [1/s], and its largest sum of |velocity| / spacing [1/s].
double frequency_of(const Parameters&, const Column&);
double courant_rate_of(const Parameters&, const Column&);

/// The length of the Euler steps that stages are convex sums of, in steps.
double longest_stage(TimeScheme);
/// Arrays that a prognostic field needs: its own, and one to three for stages.
int state_arrays(const Parameters&);
/// Bytes of all fields of a run.
size_t memory_needed(const Parameters&);

struct Effect;  // effect.h
using EffectMaker = Effect (*)();
namespace effect {
Effect momentum(), buoyancy(), moisture(), latent_heat(), vapour(), loading(), anelastic(), dye(), rain(), friction(),
    floor_fluxes(), surface_stress(), surface_exchange(), viscosity(), diffusion(), subgrid(), radiation(),
    subsidence(), coriolis(), large_scale_tendencies(), sponge(), wind_relaxation(), side_relaxation(), moving_frame(),
    hot_buoyancy(), combustion(), cooling(), sources(), colliders();
}

/// The effects, in the order in which their terms are added, which results depend on in their last bits. A new effect
/// is its members of Parameters, its name here, and effects/NAME.cc with all else.
inline constexpr EffectMaker effect_table[] = {
    effect::momentum,
    effect::buoyancy,
    effect::moisture,
    effect::latent_heat,
    effect::vapour,
    effect::loading,
    effect::anelastic,
    effect::dye,
    effect::rain,
    effect::combustion,
    effect::friction,
    effect::floor_fluxes,
    effect::surface_stress,
    effect::surface_exchange,
    effect::viscosity,
    effect::diffusion,
    effect::subgrid,
    effect::radiation,
    effect::subsidence,
    effect::coriolis,
    effect::large_scale_tendencies,
    effect::sponge,
    effect::wind_relaxation,
    effect::side_relaxation,
    effect::moving_frame,
    effect::hot_buoyancy,
    effect::cooling,
    effect::sources,
    effect::colliders,
};

}  // namespace vdbcloud::sim
