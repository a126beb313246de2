#include "vdbcloud/sim/step_plan.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/effect.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::sim {

namespace {

constexpr int small = 16, large = 32;  // cells of a pilot along its longest side
constexpr int most_steps = 1500;       // of a pilot
constexpr double jets = 0.2;           // finer air has narrower and faster jets: the power of the spacing, measured
constexpr double lively = 15;          // speed of a lively cumulus where there is no pilot [m/s]

/// The same box with fewer cells. A run of no more than `small` cells along each axis is its own pilot.
Parameters pilot_of(const Parameters& p)
{
    Parameters pilot = p;
    const auto& n = p.lattice.n;
    const int longest = std::max({n[0], n[1], n[2]}),
              wanted = longest <= small ? longest : std::clamp(longest / 2, small, large);
    for (size_t a = 0; a < 3; ++a) {
        if (p.lattice.flat(int(a))) continue;
        pilot.lattice.n[a] = std::max(std::min(n[a], 4), int(std::lround(double(n[a]) * wanted / longest)));
        pilot.lattice.h[a] = p.lattice.h[a] * n[a] / pilot.lattice.n[a];
    }
    const auto& m = pilot.lattice.n;
    if (!p.floor.map.empty()) {
        pilot.floor.map.clear();
        for (int j = 0; j < m[1]; ++j)
            for (int i = 0; i < m[0]; ++i)
                pilot.floor.map.push_back(
                    p.floor.map[size_t(j * n[1] / m[1]) * size_t(n[0]) + size_t(i * n[0] / m[0])]);
    }
    pilot.precision = Precision::Float;
    return pilot;
}

/// Counts steps of a run whose air moves as fast as the pilot's.
class Counter {
public:
    Counter(const Parameters& p, const Sounding& sounding, const std::function<void(Simulation&)>& start)
        : p_(p), column_(make_column(p, sounding)), rate_(courant_rate_of(p, column_))
    {
        if (!p.momentum) return;
        try {
            const Parameters coarse = pilot_of(p);
            for (size_t a = 0; a < 3; ++a) finer_ = std::max(finer_, coarse.lattice.h[a] / p.lattice.h[a]);
            finer_ *= std::pow(finer_, jets);
            pilot_ = Simulation::make(coarse, sounding);
            start ? start(*pilot_) : pilot_->start();
        } catch (const InputError&) {  // a box that cannot be coarser
            give_up();
        }
    }

    /// Steps from `from` to `to`.
    double between(double from, double to)
    {
        double sum = 0;
        while (from < to) {
            const double before = limit();
            double until = to;
            if (pilot_) {
                until = std::min(to, from + 4 * std::max(pilot_->step_limit(), 1e-3 * (to - from)));
                advance(until);
            }
            sum += (until - from) * 0.5 * (1 / before + 1 / limit());
            from = until;
        }
        return std::max(1.0, std::ceil(sum - 1e-6));
    }

private:
    double limit() const
    {
        if (p_.time_scheme == TimeScheme::HugeStep) return p_.dt > 0 ? p_.dt : never;
        const double step = step_limit(p_, rate_, p_.momentum ? frequency_of(p_, column_) : 0);
        return p_.dt > 0 ? std::min(step, p_.dt) : step;
    }

    void advance(double time)
    {
        try {
            pilot_->advance_to(time, [&](double) { return ++steps_ < most_steps; });
            const Budget budget = pilot_->budget();
            if (budget.dt > 0) rate_ = finer_ * budget.courant / budget.dt;
        } catch (const Cancelled&) {
            pilot_.reset();  // the rest of the run is as fast as its last part
        } catch (const ConvergenceError&) {
            pilot_.reset();
        }
    }

    void give_up()
    {
        pilot_.reset();
        double h = never;
        for (const int axis : {0, 1, 2})
            if (!p_.lattice.flat(axis)) h = std::min(h, p_.lattice.h[size_t(axis)]);
        rate_ = std::max(rate_, lively / h);
    }

    const Parameters& p_;
    Column column_;
    double rate_;       // largest sum of |velocity| / spacing of the run [1/s]
    double finer_ = 1;  // spacing of the pilot over that of the run
    std::unique_ptr<Simulation> pilot_;
    int steps_ = 0;
};

}  // namespace

double expected_steps(const Parameters& p, const Sounding& sounding, const std::vector<double>& times,
                      const std::function<void(Simulation&)>& start)
{
    Parameters plain = p;
    if (p.time_scheme == TimeScheme::HugeStep) plain.momentum = false;  // no limit: no pilot
    Counter counter(plain, sounding, start);
    double steps = 0, from = 0;
    const auto advance = [&](double to) {
        if (to > from) steps += counter.between(from, to);
        from = std::max(from, to);
    };
    for (const double time : times) {
        std::vector<double> ends{p.floor.until};
        for (const FieldSource& source : p.sources)
            for (const double end : source.step_ends()) ends.push_back(end);
        std::sort(ends.begin(), ends.end());
        for (const double end : ends)
            if (from < end && end < time) advance(end);
        advance(time);
    }
    return steps;
}

Workload simulation_work(const Parameters& p, double steps, double frames, std::optional<double> iterations)
{
    Workload work;
    const auto cells = double(p.lattice.cells());
    work.add("sim_frame_cell", frames * cells);
    if (p.time_scheme == TimeScheme::HugeStep) {
        work.add("sim_huge_cell", steps * cells * (p.maccormack ? 2.5 : 1));
        return work;
    }
    const double stages = p.time_scheme == TimeScheme::Rk3 ? 4 : p.time_scheme == TimeScheme::Rk2 ? 2 : 1;
    work.add("sim_step", stages * steps);
    work.add("sim_cell", stages * steps * cells);
    if (p.precision == Precision::Double) work.add("sim_double_cell", stages * steps * cells);
    const int effects = p.dye + p.rain + p.combustion.on + (p.cooling > 0) + p.subgrid + (p.viscosity > 0) +
                        (p.diffusivity > 0) + (p.radiation > 0);
    work.add("sim_effect_cell", stages * steps * cells * effects);
    // Of a ball and of terrain alike; see tests/sim/collider_test.cc.
    constexpr double usual = 15;
    if (!p.colliders.empty()) work.add("sim_collider_cell", iterations.value_or(usual * stages * steps) * cells);
    return work;
}

}  // namespace vdbcloud::sim
