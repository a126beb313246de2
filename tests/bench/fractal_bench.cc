// What a fractal cloud costs, as multiples of the bare transform of its size on the same threads.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/grid/grid_file.h"

#include <benchmark/benchmark.h>
#include <fftw3.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>

namespace vdbcloud {
namespace {

// The default cloud of fractalgen in a cube.
const Box domain{{-1, 0, -1}, {1, 2, 1}};
const Spectrum spectrum{1, 4.2, 4};

EnvelopePtr envelope()
{
    Box box = domain.inset(0.144);
    box.low[1] = 0;
    return cumulus_envelope(box, {});
}

/// Processor seconds of all threads: what other work on the machine changes least.
double cpu_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct Stopwatch {
    double total = 0;
    template<typename F>
    auto operator()(F f)
    {
        const double start = cpu_seconds();
        auto result = f();
        total += cpu_seconds() - start;
        return result;
    }
};

/// Arguments: voxels along an edge, threads. Everything is timed in turn in every iteration, so that the
/// ratios hold on a busy machine. The columns are processor seconds, and `x_...` that over the bare
/// transform.
void cumulus(benchmark::State& state)
{
    const int n = int(state.range(0));
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(state.range(1)));
    fft::RealField<float> field({n, n, n});
    const fft::RealTransform<float> transform({n, n, n});
    Stopwatch bare, noise, shape, build, write;
    const auto path =
        std::filesystem::temp_directory_path() / ("fractal_bench_" + std::to_string(std::clock()) + ".vdb");
    long voxels = 0;
    for (auto _ : state) {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) std::fill_n(field.row(i, j), field.row_length(), 0.1f);
        bare([&] { return transform.backward(field), 0; });
        const auto n_field = noise([&] { return synthesize({n, n, n}, domain.sides(), spectrum); });
        const auto cloud = shape([&] { return shape_cloud(n_field, domain, *envelope(), {}); });
        const auto grid = build([&] { return cloud_grid(cloud); });
        GridFile file;
        file.metadata = std::make_shared<MetaMap>();
        file.grids = {grid};
        write([&] { return write_grid_file(path.string(), file), 0; });
        voxels = long(grid->activeVoxelCount());
    }
    std::filesystem::remove(path);
    const double runs = double(state.iterations());
    state.counters["transform_s"] = bare.total / runs;
    state.counters["noise_s"] = noise.total / runs;
    state.counters["shape_s"] = shape.total / runs;
    state.counters["tree_s"] = build.total / runs;
    state.counters["write_s"] = write.total / runs;
    state.counters["x_noise_and_shape"] = (noise.total + shape.total) / bare.total;
    state.counters["Mvoxel"] = double(voxels) / 1e6;
}
BENCHMARK(cumulus)
    ->ArgNames({"n", "threads"})
    ->Args({128, 1})
    ->Args({256, 1})
    ->Args({256, 2})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->MinWarmUpTime(0.1)
    ->MinTime(2);

/// Our transform of 256^3 reals against FFTW's own plan for it, both estimated and on one thread.
void transform_against_fftw(benchmark::State& state)
{
    const int n = int(state.range(0));
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    fft::RealField<float> field({n, n, n});
    const fft::RealTransform<float> transform({n, n, n});
    const int size[3] = {n, n, n}, reals[3] = {n, n, int(field.row_length())},
              modes[3] = {n, n, int(field.row_length() / 2)};
    auto* data = reinterpret_cast<fftwf_complex*>(field.row(0, 0));
    const auto plan =
        fftwf_plan_many_dft_c2r(3, size, 1, data, modes, 1, 0, field.row(0, 0), reals, 1, 0, FFTW_ESTIMATE);
    Stopwatch ours, theirs;
    for (auto _ : state) {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) std::fill_n(field.row(i, j), field.row_length(), 0.1f);
        ours([&] { return transform.backward(field), 0; });
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) std::fill_n(field.row(i, j), field.row_length(), 0.1f);
        theirs([&] { return fftwf_execute(plan), 0; });
    }
    fftwf_destroy_plan(plan);
    state.counters["ours_s"] = ours.total / double(state.iterations());
    state.counters["fftw_s"] = theirs.total / double(state.iterations());
    state.counters["x_ours"] = ours.total / theirs.total;
}
BENCHMARK(transform_against_fftw)->ArgName("n")->Arg(128)->Arg(240)->Arg(256)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vdbcloud
