#pragma once
// The state of a run in one precision, and the terms that act on it. Private to sim/: effects register here.
#include "vdbcloud/sim/openness.h"
#include "vdbcloud/sim/parallel.h"
#include "vdbcloud/sim/projection.h"
#include "vdbcloud/sim/relaxation.h"
#include "vdbcloud/sim/simulation.h"

#include <array>
#include <deque>
#include <functional>
#include <vector>

namespace vdbcloud::sim {

/// Mean over the mass of the air, and bounds, of a quantity less its reference.
struct Extent {
    double mean = 0, low = never, high = -never;
};

/// A transported quantity with room for the stages of a step; a[0] holds the state between steps.
template<typename T>
struct Variable {
    /// Adds a rate [unit/s] to the row (j, k) of `out`, from the arrays `in` of the state.
    using Term = std::function<void(int in, int j, int k, T* out)>;

    Quantity quantity = Quantity::U;
    Place place = Place::Centre;
    std::array<Field<T>, 4> a;
    /// Fluxes through the floor, as rates of the lowest cells: called for k = 0 alone.
    std::vector<Term> floor;
    /// Sources of a row: whatever is not the divergence of a flux through faces.
    std::vector<Term> terms;
    /// Rates below 0 that take no more than there is, as terms.
    std::vector<Term> sinks;
    /// Changes the row (j, k) at the end of a step of length dt [s], before the projection.
    std::vector<std::function<void(double dt, int j, int k, T* row)>> holds;
    /// Terms that mix and so limit an explicit step: see Effect::fastest_rate.
    std::vector<Term> stiff;
    /// Return to the environment, which limits no step.
    Relaxation relaxation;
    // Accounts: sum of sources over cells and time, in cell values [unit]; what there was at the start.
    mutable std::vector<double> row_source;
    double sources = 0;
    double turnover = 0;  ///< the same sum of absolute values
    Extent start;

    /// Adds to the accounts what cells gained, a sum weighted with the density of the base state.
    void gain(double sum) { sources += sum, turnover += sum < 0 ? -sum : sum; }

    explicit operator bool() const { return bool(a[0]); }
    /// Calls `floor` and `terms`.
    void add_sources(int in, int j, int k, T* out) const
    {
        if (k == 0)
            for (const Term& term : floor) term(in, j, k, out);
        for (const Term& term : terms) term(in, j, k, out);
    }
    /// Whether anything changes it beside transport.
    bool has_sources() const
    {
        return !floor.empty() || !terms.empty() || !sinks.empty() || !holds.empty() || !stiff.empty();
    }
};

template<typename T>
struct Air {
    Air(const Parameters&, const Column&, const Thermodynamics&);
    Air(const Air&) = delete;
    Air& operator=(const Air&) = delete;

    const Parameters& parameters;
    const Column& column;
    const Thermodynamics& thermo;
    const Lattice lattice;
    const BaseDensity rho;
    Openness<T> bodies;  ///< empty without colliders

    std::array<Variable<T>, 3> wind;
    Variable<T> theta, water, rain, dye, fuel;
    double time = 0;         ///< of the state between steps [s]
    double stage_time = 0;   ///< of the values that a stage reads [s]
    double dt = 0;           ///< of the step that is taken, or was last [s]
    double rain_fallen = 0;  ///< on the floor since the start [kg/m^2]

    // What effects register.
    std::vector<std::function<void(int in)>> before_stage;   ///< with the arrays that the stage reads
    std::vector<std::function<void(double dt)>> after_step;  ///< on the arrays 0
    std::vector<double> step_ends;                           ///< times that steps do not pass [s]
    double friction_time = never;                            ///< of the drag -V/t, taken as an integrating factor [s]
    double fastest_rate = 0;                                 ///< of explicit mixing [1/s]
    const Field<T>* eddy_viscosity = nullptr;                ///< [m^2/s], where sub-grid mixing is on

    /// Allocates the arrays of a scalar for all stages.
    void allocate(Variable<T>&, Quantity);
    /// One more value a cell for an effect's own use, as long as this lives.
    Field<T>& add_field() { return own_.emplace_back(lattice); }
    /// The sounding's value at each level, in the units of the field; 0 of quantities that it does not have.
    std::vector<double> environment(Quantity) const;
    /// The relaxation of a quantity, with the environment as its target.
    Relaxation& relax(Variable<T>&);
    /// False from the time on at which the fluxes through the floor end: steps end there.
    bool floor_has_fluxes() const { return time < flux_end(parameters); }

    Variable<T>& of(Quantity);
    const Variable<T>& of(Quantity q) const { return const_cast<Air*>(this)->of(q); }
    /// Those that this run has.
    std::vector<Variable<T>*> scalars();
    std::vector<Variable<T>*> velocities();
    /// What the field of a quantity is counted from: of a velocity that of the box over the ground.
    double reference(Quantity) const;
    /// The index of the wind's arrays that belong to the scalars' arrays `at`: a given wind has one.
    size_t wind_at(int at) const { return parameters.momentum ? size_t(at) : 0; }
    /// What carries air through the lower faces of an axis, beside the scalars' arrays `at`: the wind, or its open
    /// share, which is that of the present state.
    const Field<T>& carrier(int axis, int at) const
    {
        return bodies ? bodies.flux[size_t(axis)] : wind[size_t(axis)].a[wind_at(at)];
    }
    /// Columns and rows that are computed: faces on open sides have one more than cells.
    int width(const Variable<T>& v) const { return v.place == Place::FaceX ? lattice.faces(0) : lattice.n[0]; }
    int rows(const Variable<T>& v) const { return v.place == Place::FaceY ? lattice.faces(1) : lattice.n[1]; }
    /// The first column of row j of a velocity that no wall stops; width() where the whole row is on a wall.
    int first_free(const Variable<T>& v, int j) const
    {
        const auto wall = [&](Place place, size_t axis) {
            return v.place == place && lattice.side[axis] == Side::Wall;
        };
        return wall(Place::FaceY, 1) && j == 0 ? width(v) : wall(Place::FaceX, 0) ? 1 : 0;
    }
    /// The columns of a component, whether this run has it or not.
    int wind_width(int axis) const { return axis == 0 ? lattice.faces(0) : lattice.n[0]; }
    /// The drag on a component of the wind.
    Drag drag(int axis) const { return {friction_time, axis < 2 ? -parameters.frame[size_t(axis)] : 0}; }
    /// How far the box has moved over the ground at a time [m].
    std::array<double, 2> moved(double at) const { return {parameters.frame[0] * at, parameters.frame[1] * at}; }
    bool moves() const { return parameters.frame[0] != 0 || parameters.frame[1] != 0; }
    bool open() const { return lattice.side[0] == Side::Open || lattice.side[1] == Side::Open; }
    size_t bytes() const;

private:
    std::deque<Field<T>> own_;
};

extern template struct Air<float>;
extern template struct Air<double>;

}  // namespace vdbcloud::sim
