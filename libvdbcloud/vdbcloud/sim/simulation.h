#pragma once
// A cloud in a box of air, independent of the precision in which it is computed.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/sim/parameters.h"

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud::sim {

/// What a simulation transports. U, V, W are on lower faces, the others at centres.
enum class Quantity { U, V, W, Theta, Water, Rain, Dye, Fuel };

/// Budgets and extremes at one time. Means are weighted with the density of the base state. Drifts exclude sources and
/// what passed open sides.
struct Budget {
    double time = 0;         ///< [s]
    uint64_t steps = 0;      ///< since the start
    uint64_t retries = 0;    ///< steps repeated with half their length, because the air became faster within them
    double dt = 0;           ///< last step [s]
    double courant = 0;      ///< maximum of dt (|u|/dx + |v|/dy + |w|/dz)
    double water_mean = 0;   ///< q_t [kg/kg]
    double water_drift = 0;  ///< change of water_mean since the start without sources, relative to its start value
    double theta_mean = 0;   ///< theta_l [K]
    double theta_drift = 0;  ///< the same of theta_mean, relative to the range of theta_l
    double divergence = 0;   ///< max |div V| h / max |V|, the environment's wind and 0.1 m/s included in the maximum
    double speed_max = 0, w_max = 0;  ///< [m/s]
    double theta_min = 0, theta_max = 0, water_min = 0, water_max = 0;
    double new_extrema = 0;  ///< excess of theta_l or q_t over the bounds of the start, per range; -1 with sources
    double cloud_base = -1, cloud_top = -1;  ///< lowest and highest cell centre with q_l > 1e-5 [m], -1: no cloud
    double cloud_max = 0;                    ///< largest q_l [kg/kg]
    double cloud_mean = 0;                   ///< mean q_l [kg/kg]
    double water_corrected = 0;          ///< water that the budget fix added or removed, summed over steps, relative
    double rain_fallen = 0;              ///< on the floor since the start [kg/m^2]
    double kinetic = 0;                  ///< mean of |V|^2/2 [m^2/s^2]
    double dye_mean = 0, dye_drift = 0;  ///< as of water, the drift relative to all dye that there was or came or went
    double fuel_mean = 0, fuel_drift = 0;  ///< the same of fuel
    std::string fault;                     ///< the first invariant out of its tolerance; empty: none
};

class Simulation {
public:
    /// Checks the parameters, allocates and sets the initial air: the sounding with bubbles and noise.
    /// Throws InputError; std::bad_alloc if there is no memory.
    static std::unique_ptr<Simulation> make(const Parameters&, const Sounding&);
    virtual ~Simulation();

    const Parameters& parameters() const { return parameters_; }
    const Column& column() const { return column_; }
    const Thermodynamics& thermodynamics() const { return thermo_; }

    /// Steps until `time` [s] exactly. The sequence of values does not depend on threads. Throws ConvergenceError
    /// naming a cell if a value is no longer finite, Cancelled between steps.
    virtual void advance_to(double time, const Progress& = {}) = 0;
    virtual double time() const = 0;
    virtual Budget budget() const = 0;
    /// Longest step that the limits allow now [s].
    virtual double step_limit() const = 0;
    /// Bytes of all fields.
    virtual size_t bytes() const = 0;
    /// Of the pressure around colliders, since this object was made; 0 without colliders.
    virtual uint64_t pressure_iterations() const = 0;

    virtual bool has(Quantity) const = 0;
    /// The cells of one plane of constant height, x fastest; faces at the box's upper ends are not included.
    /// Theta is absolute [K], velocities are over the ground.
    virtual void get_plane(Quantity, int k, double* out) const = 0;
    /// 1 in the cells of a plane that hold air, 0 in those within bodies.
    virtual void get_air_plane(int k, double* out) const = 0;
    /// Cloud water q_l of a plane [kg/kg]; 0 without moisture.
    virtual void get_cloud_plane(int k, double* out) const = 0;
    /// Heat that fuel gives to the air of a plane [K/s]; 0 without combustion.
    virtual void get_flame_plane(int k, double* out) const = 0;
    /// Brings what stages derive from the state, such as the eddy viscosity, up to the present state. Changes no state.
    virtual void derive() = 0;
    /// Eddy viscosity of a plane when derive() was called last [m^2/s]; 0 without sub-grid mixing.
    virtual void get_eddy_plane(int k, double* out) const = 0;
    /// Mean flux of a quantity through the floor, upwards: its unit times m/s, over the density at the floor.
    virtual double floor_flux(Quantity) const = 0;
    /// Replaces the state before the first step: nx ny nz values, x fastest. A velocity is projected when started.
    /// Throws InputError that begins with `source` and names the first cell whose value air cannot have: up to 500 m/s,
    /// 100..2000 K, 0..1 kg/kg of water, 0..1e6 of dye.
    virtual void set(Quantity, const std::vector<double>&, const std::string& source = "initial state") = 0;
    /// Adds a prescribed rate [unit/s] of position [m] and time [s] to a quantity's equation: large-scale forcing, or
    /// the source that makes a given flow a solution. Called from several threads. Checkpoints do not hold it: add it
    /// again before restore().
    using Source = std::function<double(double x, double y, double z, double t)>;
    virtual void add_source(Quantity, Source) = 0;
    /// Call after the last set(): budgets count from here.
    virtual void start() = 0;

    /// The whole state, bit for bit; a simulation made with equal parameters continues from it with equal bits.
    virtual void save(std::ostream&) const = 0;
    virtual void restore(std::istream&) = 0;

protected:
    Simulation(const Parameters&, const Sounding&);
    Parameters parameters_;
    Column column_;
    Thermodynamics thermo_;
};

}  // namespace vdbcloud::sim
