// What a sweep costs: nanoseconds for each active voxel and direction, against size, degree and threads.
#include "vdbcloud/scatter/harmonics.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/sweep/transport_sweep.h"
#include "support/voxel_field.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>
#include <memory>

namespace vdbcloud {
namespace {

/// Billows: a sum of waves above a threshold, about a sixth of the box of n^3 voxels, with true voids and separate pieces.
struct Cloud {
    explicit Cloud(int n)
        : index(*test::voxel_field(Vec3i(n), Vec3d(1.0 / n), [n](const Vec3i& p) {
              const Vec3d x = Vec3d(p.x(), p.y(), p.z()) / n - Vec3d(0.5);
              const double waves = std::sin(11 * x.x() + 3 * x.y()) + std::sin(13 * x.y() - 5 * x.z()) +
                                   std::sin(9 * x.z() + 7 * x.x()) + 0.4 * std::sin(41 * x.x() + 37 * x.z() - 31 * x.y());
              const double value = 0.9 + 0.5 * waves - 4 * x.dot(x);
              return value > 0.75 ? 40 * (value - 0.7) : 0.0;
          }))
    {
        const Blocks& blocks = index.blocks();
        sigma.assign(blocks.slots(), 0.0f);
        source.assign(4, sigma);
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            if (!blocks.active(slot)) continue;
            sigma[slot] = 30;
            for (int k = 0; k < 4; ++k) source[k][slot] = k == 0 ? 1.0f : 0.1f;
            for (int face = 0; face < 6; ++face)
                if (!blocks.active(blocks.neighbour(slot, face))) faces.push_back({uint32_t(slot), uint8_t(face)});
        }
        sweep = std::make_unique<TransportSweep>(index, faces);
    }
    VoxelIndex index;
    std::vector<float> sigma;
    std::vector<std::vector<float>> source;
    std::vector<SweepFace> faces;
    std::unique_ptr<TransportSweep> sweep;
};

Cloud& cloud(int n)
{
    static std::map<int, std::unique_ptr<Cloud>> known;
    auto& one = known[n];
    if (!one) one = std::make_unique<Cloud>(n);
    return *one;
}

/// Arguments: edge of the box [voxels], directions, threads.
void sweeps(benchmark::State& state)
{
    Cloud& c = cloud(int(state.range(0)));
    const Ordinates o = ordinates(OrdinateKind::Product, int(state.range(1)), 1);
    SweepSet set;
    set.source_terms = 4;
    set.moment_terms = 9;
    std::vector<double> y(9);
    for (size_t m = 0; m < o.count(); ++m) {
        evaluate_harmonics(2, o.direction[m], y.data());
        set.direction.push_back(o.direction[m]);
        set.weight.push_back(float(o.weight[m]));
        set.source_basis.insert(set.source_basis.end(), y.begin(), y.begin() + 4);
        set.moment_basis.insert(set.moment_basis.end(), y.begin(), y.end());
        set.inflow.push_back(1.0f);
    }
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, size_t(state.range(2)));
    SweepResult result;
    const SweepFields fields{&c.sigma, &c.source};
    c.sweep->run(set, fields, result);  // finds which rays end in the sky
    for (auto _ : state) c.sweep->run(set, fields, result);
    const double work = double(c.index.blocks().active_count()) * double(set.count());
    state.counters["voxels"] = double(c.index.blocks().active_count());
    state.counters["fill"] = double(c.index.blocks().active_count()) / double(c.index.blocks().count() * 512);
    state.counters["bytes_per_voxel"] = double(c.sweep->bytes()) / double(c.index.blocks().active_count());
    state.counters["per_voxel_direction"] =
        benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(sweeps)
    ->ArgNames({"edge", "directions", "threads"})
    ->Args({64, 32, 1})
    ->Args({128, 32, 1})
    ->Args({256, 32, 1})
    ->Args({256, 32, 2})
    ->Args({128, 256, 1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vdbcloud
