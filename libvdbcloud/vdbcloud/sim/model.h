#pragma once
// The simulation in one precision: fields, stages, and the terms that are on. Internal to this module.
#include "vdbcloud/sim/projection.h"
#include "vdbcloud/sim/simulation.h"
#include "vdbcloud/sim/sweep.h"

#include <array>
#include <functional>
#include <optional>

namespace vdbcloud::sim {

/// Mean over the mass of the air, and bounds, of a quantity less its reference.
struct Extent {
    double mean = 0, low = never, high = -never;
};

/// A transported quantity with room for the stages of a step; a[0] holds the state between steps.
template<typename T>
struct Variable {
    Quantity quantity = Quantity::U;
    Place place = Place::Centre;
    std::array<Field<T>, 3> a;
    /// Sources of a row, added to `out`: whatever is not the divergence of a flux through faces.
    std::vector<std::function<void(int in, int j, int k, T* out)>> terms;
    /// The same, for terms that damp or mix and so limit an explicit step (Model::fastest_rate_).
    std::vector<std::function<void(int in, int j, int k, T* out)>> stiff;
    // Accounts: sum of sources over cells and time, in cell values [unit]; what there was at the start.
    mutable std::vector<double> row_source;
    double sources = 0;
    Extent start;

    explicit operator bool() const { return bool(a[0]); }
};

/// One stage of a step of length 1: reads a[in], writes a[out] = scalar or momentum formula of rows.h with x0 = a[0],
/// x1 = a[x1], x = a[in].
struct Stage {
    int in, x1, out;
    double time_in, time_x1, time_out;  // where these are, as fractions of the step
    double alpha, beta, tau;            // ScalarStage of a step of length 1
    double weight;                      // of this stage's tendency in the whole step
};
const std::vector<Stage>& stages(TimeScheme);

template<typename T>
class Model final : public Simulation {
public:
    Model(const Parameters&, const Sounding&);

    void advance_to(double time, const Progress&) override;
    double time() const override { return time_; }
    Budget budget() const override;
    double step_limit() const override;
    size_t bytes() const override;
    bool has(Quantity) const override;
    void get_plane(Quantity, int k, double* out) const override;
    void get_cloud_plane(int k, double* out) const override;
    void set(Quantity, const std::vector<double>&) override;
    void add_source(Quantity, Source) override;
    void start() override;
    void save(std::ostream&) const override;
    void restore(std::istream&) override;

private:
    // initial.cc, budget.cc
    void set_initial_air();
    Extent extent(const Variable<T>&) const;
    void find_weather(Budget&) const;
    std::string fault_in(const Budget&) const;
    [[noreturn]] void name_bad_cell() const;

    // model.cc
    bool step(double dt);
    void finish_state(int at);
    void take_courant(int at);
    void find_buoyancy(int at);
    void advance_scalar(Variable<T>&, const Stage&, double dt);
    void advance_velocity(int axis, const Stage&, double dt);
    void settle(const Stage&, double dt);
    double stratification() const;
    double reference(Quantity) const;
    Variable<T>& of(Quantity q);
    const Variable<T>& of(Quantity q) const { return const_cast<Model*>(this)->of(q); }
    std::vector<Variable<T>*> scalars();
    std::vector<Variable<T>*> velocities();

    // subgrid.cc, terms.cc: one function an effect, called where it is on
    void add_subgrid();
    void find_eddy_viscosity(int at);
    void add_terms();
    void add_floor_fluxes();
    void add_diffusion();
    void add_radiation();
    void add_sponge();
    void add_wind_relaxation();
    void add_side_relaxation();
    void find_heating(int at);
    void find_mean_wind(int at);

    // microphysics.cc, semi_lagrangian.cc
    void rain(double dt);
    void huge_step(double dt);
    void huge_buoyancy(double dt);
    void huge_transport(Variable<T>&, double dt);
    void huge_sources(Variable<T>&, double dt);
    void fix_budget(Variable<T>&);

    Lattice lattice_;
    BaseDensity rho_;
    std::array<Variable<T>, 3> wind_;
    Variable<T> theta_, water_, rain_, dye_;
    Field<T> drain_;  // time in which the outflow empties a cell [s]
    std::optional<Projection<T>> pressure_;
    Field<T> eddy_, heating_;              // only with sub-grid mixing, radiation
    std::vector<double> mean_u_, mean_v_;  // only with wind relaxation
    std::vector<std::function<void(int at)>> before_stage_;
    double fastest_rate_ = 0;  // of the terms' explicit damping and diffusion [1/s]
    double side_rate_ = 0;

    double time_ = 0, dt_ = 0, rate_ = 0;  // rate_: largest Courant rate [1/s]
    double stage_time_ = 0;                // of the values a stage reads [s]
    uint64_t steps_ = 0, retries_ = 0;
    double rain_fallen_ = 0, water_corrected_ = 0;
    bool started_ = false;
};

}  // namespace vdbcloud::sim
