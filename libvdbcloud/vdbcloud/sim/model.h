#pragma once
// The simulation in one precision: how a step is made of stages. Private to sim/.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/flux_rows.h"
#include "vdbcloud/sim/obstacle_solve.h"
#include "vdbcloud/sim/stages.h"

#include <optional>

namespace vdbcloud::sim {

template<typename T>
class Model final : public Simulation {
public:
    Model(const Parameters&, const Sounding&);

    void advance_to(double time, const Progress&) override;
    double time() const override { return air_.time; }
    Budget budget() const override;
    double step_limit() const override;
    size_t bytes() const override;
    uint64_t pressure_iterations() const override { return obstacles_ ? obstacles_->iterations() : 0; }
    bool has(Quantity) const override;
    void get_plane(Quantity, int k, double* out) const override;
    void get_air_plane(int k, double* out) const override;
    void get_cloud_plane(int k, double* out) const override;
    void get_flame_plane(int k, double* out) const override;
    void derive() override;
    void get_eddy_plane(int k, double* out) const override;
    double floor_flux(Quantity) const override;
    void set(Quantity, const std::vector<double>&, const std::string& source) override;
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
    void project(int at);
    void find_flux(int at);
    void clear_bodies();
    void finish_state(int at);
    void finish_scalars(int at, bool rows);
    void finish_stage(int at);
    void apply_after_step(double dt);
    void take_courant(int at);
    void find_buoyancy(int at);
    void advance_scalar(Variable<T>&, const Stage&, double dt);
    struct Stock {
        const T* x;
        double least, tau;
    };
    double take_out(const Variable<T>&, int in, int j, int k, const Stock&, T* tendency);
    double hold(const Variable<T>&, double dt, int j, int k, T* row, int n);
    void advance_velocity(int axis, const Stage&, double dt);
    void relax_means(Variable<T>&, const TimedStage&, LevelMeans&);
    void huge_relaxation(Variable<T>&, double dt);
    double stratification() const;
    double windiest() const;

    // semi_lagrangian.cc
    void huge_step(double dt);
    void huge_buoyancy(double dt);
    void huge_transport(Variable<T>&, double dt);
    void huge_sources(Variable<T>&, double dt);
    void fix_budget(Variable<T>&);

    Air<T> air_;
    Field<T> drain_;  // time in which the outflow empties a cell [s]
    std::optional<Projection<T>> pressure_;
    std::optional<ObstacleSolve<T>> obstacles_;
    double rate_ = 0;  // largest Courant rate [1/s]
    uint64_t steps_ = 0, retries_ = 0;
    double water_corrected_ = 0;
    bool started_ = false;
};

}  // namespace vdbcloud::sim
