// Steps that a simulation would take, against those that it takes.
#include "vdbcloud/sim/step_plan.h"

#include "vdbcloud/sim/presets.h"

#include "support/size.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

double taken(const Parameters& p, const Sounding& sounding, const std::vector<double>& times)
{
    auto sim = Simulation::make(p, sounding);
    sim->start();
    for (const double time : times) sim->advance_to(time);
    return double(sim->budget().steps);
}

/// A cumulus whose bubble rises from rest.
Preset cumulus(int cells)
{
    Preset run = preset("cumulus");
    Lattice& lattice = run.parameters.lattice;
    for (size_t a = 0; a < 3; ++a) {
        lattice.h[a] *= double(lattice.n[a]) / cells;
        lattice.n[a] = cells;
    }
    return run;
}

TEST(StepPlan, IsExactWhereOptionsSetTheStep)
{
    Preset run = cumulus(8);
    run.parameters.dt = 0.5;
    EXPECT_EQ(expected_steps(run.parameters, run.sounding, {10, 20}), 40);
    run.parameters.dt = 3;  // ten seconds are four steps of 2.5 s
    EXPECT_EQ(expected_steps(run.parameters, run.sounding, {10, 20}), taken(run.parameters, run.sounding, {10, 20}));
    run.parameters.time_scheme = TimeScheme::HugeStep;
    run.parameters.dt = 0;
    run.parameters.floor.until = 15;  // steps land on it
    EXPECT_EQ(expected_steps(run.parameters, run.sounding, {10, 20}), 3);
}

TEST(StepPlan, FollowsTheSpeedOfAPilot)
{
    // The pilot is the run itself, and then has two thirds, at full size half of the cells along each axis. Steps
    // are few while the air is at rest, and many when it moves at 10 m/s; coarse air is about as fast.
    for (const int cells : {12, test::sized(24, 48)}) {
        const Preset run = cumulus(cells);
        std::vector<double> times;
        for (int k = 1; k <= 6; ++k) times.push_back(100.0 * k);
        const double said = expected_steps(run.parameters, run.sounding, times);
        const double steps = taken(run.parameters, run.sounding, times);
        EXPECT_GT(steps, 20);
        EXPECT_NEAR(said / steps, 1, cells == 12 ? 0.1 : 0.25)
            << cells << " cells: said " << said << ", taken " << steps;
    }
}

TEST(StepPlan, EndsSoonWhereStepsAreMany)
{
    // A viscosity whose limit takes 1e5 steps: known without them, within what the rounding of a frame adds.
    Preset run = cumulus(8);
    run.parameters.viscosity = 8e5;
    const double limit = step_limit(run.parameters, 0, 0);
    EXPECT_NEAR(expected_steps(run.parameters, run.sounding, {600}), 600 / limit, 0.2 * 600 / limit);
    EXPECT_GT(600 / limit, 5e3);
}

TEST(StepPlan, WorkIsCellsTimesStages)
{
    const Preset run = cumulus(8);
    const Workload work = simulation_work(run.parameters, 10, 3);
    EXPECT_EQ(work.of("sim_cell"), 10 * 4 * 512);
    EXPECT_EQ(work.of("sim_frame_cell"), 3 * 512);
    EXPECT_EQ(work.of("sim_double_cell"), 0);
    Parameters twice = run.parameters;
    twice.precision = Precision::Double;
    twice.time_scheme = TimeScheme::Rk2;
    twice.rain = true;
    EXPECT_EQ(simulation_work(twice, 10, 3).of("sim_cell"), 10 * 2 * 512);
    EXPECT_EQ(simulation_work(twice, 10, 3).of("sim_double_cell"), 10 * 2 * 512);
    EXPECT_EQ(simulation_work(twice, 10, 3).of("sim_effect_cell"),
              10 * 2 * 512 * (1.0 + (twice.radiation > 0) + twice.subgrid));
    twice.time_scheme = TimeScheme::HugeStep;
    EXPECT_EQ(simulation_work(twice, 10, 3).of("sim_cell"), 0);
    EXPECT_GT(simulation_work(twice, 10, 3).of("sim_huge_cell"), 0);
}

}  // namespace
}  // namespace vdbcloud::sim
