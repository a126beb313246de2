#pragma once
// A cloud in a box of air: what one can do with a simulation without knowing its precision.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/sim/parameters.h"

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud::sim {

/// What a simulation carries along. U, V, W are on lower faces, the others at centres.
enum class Quantity { U, V, W, Theta, Water, Rain, Dye };

/// One line of accounts: what must be conserved, what must vanish, and what one wants to see. Means are weighted
/// with the density of the base state; sources and what passed open sides are already taken off the drifts.
struct Budget {
    double time = 0;         ///< [s]
    uint64_t steps = 0;      ///< so far
    uint64_t retries = 0;    ///< steps repeated with half their length, as the air had sped up too much
    double dt = 0;           ///< last step [s]
    double courant = 0;      ///< dt (|u|/dx + |v|/dy + |w|/dz), its maximum
    double water_mean = 0;   ///< q_t [kg/kg]
    double water_drift = 0;  ///< of water_mean since the start, less sources, relative to its start value
    double theta_mean = 0;   ///< theta_l [K]
    double theta_drift = 0;  ///< less sources, relative to the range of theta_l
    double divergence = 0;   ///< max |div V| h / max |V|, the environment's wind and 0.1 m/s included in the maximum
    double speed_max = 0, w_max = 0;  ///< [m/s]
    double theta_min = 0, theta_max = 0, water_min = 0, water_max = 0;
    double new_extrema = 0;  ///< by how much theta_l or q_t left its start's bounds [of their range]; -1 with sources
    double cloud_base = -1, cloud_top = -1;  ///< lowest and highest cell centre with q_l > 1e-5 [m], -1: no cloud
    double cloud_max = 0;                    ///< largest q_l [kg/kg]
    double cloud_mean = 0;                   ///< mean q_l [kg/kg]
    double water_corrected = 0;  ///< sum over steps of the water given back or taken by --fix-budget, of what there is
    double rain_fallen = 0;      ///< on the floor since the start [kg/m^2]
    double kinetic = 0;          ///< mean of |V|^2/2 [m^2/s^2]
    std::string fault;           ///< the first invariant out of its tolerance, in words; empty: all are kept
};

class Simulation {
public:
    /// Checks everything, allocates and sets the initial air: the sounding with bubbles and noise.
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

    virtual bool has(Quantity) const = 0;
    /// The cells of one plane of constant height, x fastest; faces that are the box's upper ends are left out.
    /// Theta is absolute [K].
    virtual void get_plane(Quantity, int k, double* out) const = 0;
    /// Cloud water q_l of a plane [kg/kg]; 0 without moisture.
    virtual void get_cloud_plane(int k, double* out) const = 0;
    /// Replaces the state before the first step: nx ny nz values, x fastest. A velocity is projected when started.
    virtual void set(Quantity, const std::vector<double>&) = 0;
    /// Adds a prescribed rate [unit/s] of position [m] and time [s] to a quantity's equation, beside all else:
    /// large-scale forcing, or what makes a given flow a solution. Called from several threads. Not part of
    /// checkpoints: add it again before restore().
    using Source = std::function<double(double x, double y, double z, double t)>;
    virtual void add_source(Quantity, Source) = 0;
    /// Call after the last set(): starts accounts from here.
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
