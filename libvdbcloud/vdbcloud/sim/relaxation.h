#pragma once
// Linear return to the environment, dq/dt = -r (q - q_env), by the stages of a step: alone it is the exact factor
// exp(-r dt) of any step, so that it limits no step. Private to sim/.
//
// Velocities take the part of r dt up to 0.5 as a tendency, with the rate for which the stages of a scheme give the
// exact factor, and the rest as an integrating factor. The tendency keeps the order of the scheme: an integrating
// factor that differs from cell to cell does not commute with the projection. Scalars are not projected and take all of
// it as an integrating factor, so that a stage stays a convex combination.
#include "vdbcloud/sim/field.h"
#include "vdbcloud/sim/rows.h"

#include <cstdint>
#include <vector>

namespace vdbcloud::sim {

struct Stage;

/// Rates of one quantity [1/s]. The rates of the level and of the column of a cell add.
struct Relaxation {
    std::vector<double> environment;  ///< q_env of each level, in the units of the field
    std::vector<double> level;        ///< of each level; empty: 0
    std::vector<double> rates;        ///< that columns have; the first is 0
    std::vector<uint16_t> column;     ///< for each column of the field, x fastest, the index of its rate; empty: 0
    double mean = 0;                  ///< of the mean over a level; what differs from the mean keeps its own rate

    bool none() const { return level.empty() && column.empty() && mean == 0; }
    double level_rate(int k) const { return level.empty() ? 0 : level[size_t(k)]; }
    double column_rate(size_t c) const { return column.empty() ? 0 : rates[column[c]]; }
    /// One rate for each column.
    void set_columns(const std::vector<double>&);
};

/// Drag -(V - ground)/time: the ground moves in a box that moves over it.
struct Drag {
    double time;    ///< [s]
    double ground;  ///< the component of the ground's velocity in the box [m/s]
};

/// A stage of a step of length dt [s] by a scheme of the stages `all`.
struct TimedStage {
    const Stage& stage;
    const std::vector<Stage>& all;
    double dt;
    Drag drag;
};

/// Where drag and a return at `rate` towards `environment` lead: their common state of rest.
double rest_of(double rate, double environment, const Drag&);

/// What a stage combines: out = x0 a[0] + x1 a[1] + x a[in] + tendency (rate of a[in]) + rest (rest_of()).
struct StageWeights {
    double x0, x1, x, tendency, rest;

    double value(double v0, double v1, double v, double rate, double at_rest) const
    {
        return x0 * v0 + x1 * v1 + x * v + tendency * rate + rest * at_rest;
    }
};
/// Of a velocity that returns at `rate`.
StageWeights weights_of(const TimedStage&, double rate);

/// Integrating factors of each rate of the columns, from the times of x0, x1 and x to the time that the stage writes.
struct ColumnFactors {
    ColumnFactors(const Relaxation&, const Stage&, double dt);
    bool none() const { return column.empty(); }

    const std::vector<uint16_t>& column;  // of the relaxation, which has to outlive this
    std::vector<double> x0, x1, x;
};

/// Adds to the tendencies of a row of a scalar what makes the values that the stage writes return as well. `plain`: the
/// weights without a return; `first`: the index of the row's first column. Returns the sum of what was added.
template<typename T>
double add_return(const StageWeights& plain, const ColumnFactors&, size_t first, const StageRows<T>&,
                  double environment, T* tendency, int n);

/// Weights of a velocity in columns that return to the environment.
class ColumnWeights {
public:
    ColumnWeights(const Relaxation&, const TimedStage&);
    bool none() const { return column_.empty(); }
    bool acts(size_t column) const { return column_[column] > 0; }
    /// The values of row (j, k) where a column acts, `width` columns a row; other values of `out` stay. `out` may not
    /// be an input.
    template<typename T>
    void row(int j, int k, const StageRows<T>&, T* out, int width) const;

private:
    const std::vector<uint16_t>& column_;
    size_t rates_;
    // By level and rate; `rest` times the value at rest.
    std::vector<StageWeights> weights_;
};

/// Means over the cells of each level.
template<typename T>
std::vector<double> level_means(const Lattice&, const Field<T>&);

/// What to add to each level that a stage wrote, so that its mean relaxes as well. `means`: of x0, x1, x and of the
/// values that the stage wrote with the rates of the level alone.
struct LevelMeans {
    std::vector<double> x0, x1, x, out;
};
std::vector<double> mean_shifts(const Relaxation&, const TimedStage&, const LevelMeans&);

}  // namespace vdbcloud::sim
