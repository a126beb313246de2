// Pass one: what the lattice costs against a ray for each voxel, and how both grow with the grid. All in one run.
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/light/transmittance_grid.h"

#include "support/fields.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <ctime>

namespace vdbcloud {
namespace {

/// A thresholded fractal cloud of n^3 voxels, about a fifth of them active, 20 mean free paths thick.
FloatGridPtr cloud(int n)
{
    Spectrum spectrum;
    spectrum.seed = 3;
    const auto noise = synthesize(Vec3i(n), Vec3d(1), spectrum);
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0 / n));
    auto accessor = grid->getAccessor();
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z)
                if (const float v = noise(x, y, z); v > 0.8f)
                    accessor.setValueOn(openvdb::Coord(x, y, z), std::min(1.0f, 3 * (v - 0.8f)));
    return grid;
}

double cpu_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

void light(benchmark::State& state)
{
    const auto density = cloud(int(state.range(0)));
    const bool with_exact = state.range(0) <= 256;
    Medium medium;
    medium.sigma_t_per_density = Vec3d(60);
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    TransmittanceOptions lattice, exact{Fidelity::Exact};
    lattice.error_samples = 2000;
    TransmittanceReport report;
    double lattice_seconds = 0, exact_seconds = 0;
    for (auto _ : state) {
        double start = cpu_seconds();
        transmittance_grid(*density, medium, sun, lattice, {}, &report);
        // The comparison with exact rays is a service, not the method: timed apart and taken out.
        const double with_report = cpu_seconds() - start;
        start = cpu_seconds();
        transmittance_grid(*density, medium, sun, lattice);
        lattice_seconds += std::min(with_report, cpu_seconds() - start);
        if (!with_exact) continue;
        start = cpu_seconds();
        transmittance_grid(*density, medium, sun, exact);
        exact_seconds += cpu_seconds() - start;
    }
    state.counters["voxels"] = double(report.voxels);
    state.counters["lattice_ns_per_voxel"] = 1e9 * lattice_seconds / double(state.iterations()) / double(report.voxels);
    if (with_exact) state.counters["exact_over_lattice"] = exact_seconds / lattice_seconds;
    state.counters["mean_error"] = report.mean_error;
}

BENCHMARK(light)->Arg(64)->Arg(128)->Arg(256)->Arg(512)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vdbcloud
