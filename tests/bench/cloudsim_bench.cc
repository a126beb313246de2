// Cell-steps a second of the convection model, beside the memory bandwidth of the same run (a STREAM triad), so that
// machines and days can be compared: look at the ratios. Arguments are edge of the box and threads.
#include "vdbcloud/sim/presets.h"
#include "vdbcloud/sim/projection.h"
#include "vdbcloud/sim/simulation.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <ctime>
#include <functional>
#include <vector>

namespace vdbcloud::sim {
namespace {

using Limit = tbb::global_control;

void triad(benchmark::State& state)
{
    const Limit limit(Limit::max_allowed_parallelism, size_t(state.range(0)));
    const size_t n = size_t(1) << 25;
    std::vector<float> a(n, 0.f), b(n, 1.f), c(n, 2.f);
    for (auto _ : state) {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, n, n / 16), [&](const auto& r) {
            float* __restrict out = a.data();
            for (size_t i = r.begin(); i < r.end(); ++i) out[i] = b[i] + 3.f * c[i];
        });
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(int64_t(state.iterations()) * int64_t(n) * 12);
}

Parameters cloudy(int n)
{
    Parameters p;
    p.lattice = {{n, n, n}, {4000.0 / n, 4000.0 / n, 4000.0 / n}, {Side::Periodic, Side::Periodic}};
    p.bubbles.push_back({{2000, 2000, 500}, 700, 500, 2, 2e-3, 0});
    p.noise = {0.1, 1e-4, 1000, 3};
    return p;
}

void run_steps(benchmark::State& state, const Parameters& p, int threads)
{
    const Limit limit(Limit::max_allowed_parallelism, size_t(threads));
    const Sounding sounding{"s", {0, 800, 4000}, {300, 300, 312}, {0.014, 0.013, 0}, {0, 0, 0}, {0, 0, 0}, 0};
    auto sim = Simulation::make(p, sounding);
    double time = 60;
    sim->advance_to(time);  // cloud has formed, air moves at some m/s
    const uint64_t before = sim->budget().steps;
    const std::clock_t start = std::clock();
    for (auto _ : state) sim->advance_to(time += 1);
    const double cpu = double(std::clock() - start) / CLOCKS_PER_SEC;
    const double cells = double(sim->budget().steps - before) * double(p.lattice.cells());
    state.counters["cell_steps/s"] = benchmark::Counter(cells, benchmark::Counter::kIsRate);
    state.counters["cell_steps/CPU_s"] = cells / cpu;
}

/// The default cumulus from its tenth minute on, whose steps are the longest that the limits allow.
void cumulus(benchmark::State& state)
{
    Preset run = preset("cumulus");
    Parameters& p = run.parameters;
    for (const size_t a : {0, 1, 2}) p.lattice.h[a] *= double(p.lattice.n[a]) / double(state.range(0));
    p.lattice.n.fill(int(state.range(0)));
    const Limit limit(Limit::max_allowed_parallelism, size_t(state.range(1)));
    auto sim = Simulation::make(p, run.sounding);
    double time = 600;
    sim->advance_to(time);
    const uint64_t before = sim->budget().steps;
    const std::clock_t start = std::clock();
    for (auto _ : state) sim->advance_to(time += 60);
    const double cpu = double(std::clock() - start) / CLOCKS_PER_SEC, steps = double(sim->budget().steps - before);
    state.counters["simulated_s/CPU_s"] = (time - 600) / cpu;
    state.counters["steps/simulated_s"] = steps / (time - 600);
    state.counters["cell_steps/CPU_s"] = steps * double(p.lattice.cells()) / cpu;
}

void moist_rk3(benchmark::State& state) { run_steps(state, cloudy(int(state.range(0))), int(state.range(1))); }

void moist_rk3_double(benchmark::State& state)
{
    Parameters p = cloudy(int(state.range(0)));
    p.precision = Precision::Double;
    run_steps(state, p, int(state.range(1)));
}

void dry_rk3(benchmark::State& state)
{
    Parameters p = cloudy(int(state.range(0)));
    p.moisture = false;
    run_steps(state, p, int(state.range(1)));
}

void small_preset(benchmark::State& state)
{
    Parameters p = cloudy(int(state.range(0)));
    p.time_scheme = TimeScheme::Rk2;
    p.scalar_scheme = ScalarScheme::Koren;
    run_steps(state, p, int(state.range(1)));
}

/// What one effect more or less costs in time and memory: bytes are those of all fields.
void effect(benchmark::State& state, const std::function<void(Parameters&)>& change)
{
    Parameters p = cloudy(96);
    change(p);
    const Limit limit(Limit::max_allowed_parallelism, 1);
    auto sim = Simulation::make(p, {"s", {0, 800, 4000}, {300, 300, 312}, {0.014, 0.013, 0}, {0, 0, 0}, {0, 0, 0}, 0});
    sim->start();
    state.counters["bytes/cell"] = double(sim->bytes()) / double(p.lattice.cells());
    double time = 0;
    for (auto _ : state) sim->advance_to(time += 1);
}

template<typename T>
void projection(benchmark::State& state)
{
    const Limit limit(Limit::max_allowed_parallelism, size_t(state.range(1)));
    const int n = int(state.range(0));
    const Lattice lattice{{n, n, n}, {10, 10, 10}, {Side::Periodic, Side::Periodic}};
    Projection<T> pressure(lattice, BaseDensity::uniform(n));
    Field<T> u(lattice), v(lattice), w(lattice);
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) u(i, j, k) = T((i * 7 + j * 3 + k) % 11 - 5);
    fill_halo(lattice, Place::FaceX, u);
    for (auto _ : state) pressure.project(u, v, w);
    state.counters["cells/s"] =
        benchmark::Counter(double(state.iterations()) * double(lattice.cells()), benchmark::Counter::kIsRate);
}

#define EFFECT(name, ...)                                                                                              \
    BENCHMARK_CAPTURE(effect, name, [](Parameters& p) { __VA_ARGS__; })                                                \
        ->Iterations(8)                                                                                                \
        ->MeasureProcessCPUTime()                                                                                      \
        ->Unit(benchmark::kMillisecond)
EFFECT(default, (void)p);
EFFECT(moisture_off, p.moisture = false);
EFFECT(latent_heat_off, p.moist.latent_heat = false);
EFFECT(saturation_by_height, p.moist.by = SaturationBy::Height);
EFFECT(buoyancy_off, p.moisture = p.buoyancy = false);
EFFECT(wind_prescribed_dye_only, p.moisture = p.buoyancy = p.momentum = false, p.dye = true);
EFFECT(dye_on, p.dye = true);
EFFECT(rain_on, p.rain = true);
EFFECT(friction_on, p.friction_time = 1000);
EFFECT(viscosity_on, p.viscosity = p.diffusivity = 1);
EFFECT(subgrid_on, p.subgrid = true);
EFFECT(radiation_on, p.radiation = 70);
EFFECT(sponge_on, p.sponge = 0.02);
EFFECT(shear_relaxation_on, p.wind_relaxation = 1000);
EFFECT(anelastic_on, p.anelastic = true);
EFFECT(one_cell_wide, p.lattice.n[1] = 1);

BENCHMARK(triad)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(moist_rk3)->Args({128, 1})->Args({128, 2})->Iterations(10)->UseRealTime()->MeasureProcessCPUTime()->Unit(
    benchmark::kMillisecond);
BENCHMARK(moist_rk3_double)
    ->Args({128, 1})
    ->Iterations(10)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(cumulus)->Args({64, 1})->Iterations(4)->UseRealTime()->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(dry_rk3)->Args({128, 1})->Iterations(10)->UseRealTime()->MeasureProcessCPUTime()->Unit(
    benchmark::kMillisecond);
BENCHMARK(small_preset)
    ->Args({128, 1})
    ->Iterations(10)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(projection<float>)
    ->Args({128, 1})
    ->Args({128, 2})
    ->Args({256, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(projection<double>)->Args({128, 1})->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vdbcloud::sim
