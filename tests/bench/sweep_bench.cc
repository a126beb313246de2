// What a sweep costs: nanoseconds for each active voxel and direction, against size, fill, directions, degree and
// threads.
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/scatter/harmonics.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <map>
#include <memory>

namespace vdbcloud {
namespace {

enum Scene {
    Cumulus,  ///< as fractalgen makes it: one body, an eighth of the box
    Fractal   ///< noise above a threshold, a fifth of the box: pieces of every size down to the voxel, rough at every
              ///< size of the grid
};

/// The same cloud at every n: a larger one adds detail to it.
FloatGridPtr density(Scene scene, int n)
{
    const Box domain{Vec3d(0.0), scene == Cumulus ? Vec3d(1, 0.625, 1) : Vec3d(1.0)};
    const Vec3i size(n, int(n * domain.high.y()), n);
    Spectrum spectrum;
    spectrum.seed = 7;
    spectrum.beta = scene == Cumulus ? 4.2 : 11.0 / 3;
    spectrum.outer = scene == Cumulus ? 4 : 0;
    const auto noise = synthesize(size, domain.sides(), spectrum);
    if (scene == Cumulus) {
        CumulusOptions cumulus;
        cumulus.seed = spectrum.seed;
        Box inner = domain.inset(0.072);
        inner.low.y() = 0;
        return cloud_grid(shape_cloud(noise, domain, *cumulus_envelope(inner, cumulus), {}));
    }
    CloudBlocks cloud{size, domain, {}, {}, 0};
    for (int x = 0; x < n; x += 8)
        for (int y = 0; y < n; y += 8)
            for (int z = 0; z < n; z += 8) {
                std::vector<float> values(512);
                bool any = false;
                for (int v = 0; v < 512; ++v) {
                    values[size_t(v)] = std::max(0.0f, noise(x + v / 64, y + v / 8 % 8, z + v % 8) - 0.8f);
                    any = any || values[size_t(v)] > 0;
                }
                if (!any) continue;
                cloud.storage.push_back(std::move(values));
                cloud.blocks.push_back({Vec3i(x, y, z), cloud.storage.back().data()});
            }
    return cloud_grid(cloud);
}

struct Medium {
    Medium(Scene scene, int n) : index(*density(scene, n))
    {
        const Blocks& blocks = index.blocks();
        sigma.assign(blocks.slots(), 0.0f);
        source.assign(4, sigma);
        std::vector<SweepFace> faces;
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            if (!blocks.active(slot)) continue;
            sigma[slot] = 30;
            for (int k = 0; k < 4; ++k) source[size_t(k)][slot] = k == 0 ? 1.0f : 0.1f;
            for (int face = 0; face < 6; ++face)
                if (!blocks.active(blocks.neighbour(slot, face))) faces.push_back({uint32_t(slot), uint8_t(face)});
        }
        face_count = faces.size();
        sweep = std::make_unique<TransportSweep>(index, std::move(faces));
    }
    VoxelIndex index;
    std::vector<float> sigma;
    std::vector<std::vector<float>> source;
    size_t face_count;
    std::unique_ptr<TransportSweep> sweep;
};

/// One at a time: a large one fills the memory.
Medium& medium(Scene scene, int n)
{
    static std::pair<Scene, int> known;
    static std::unique_ptr<Medium> one;
    if (!one || known != std::pair(scene, n)) {
        one.reset();
        one = std::make_unique<Medium>(scene, n);
        known = {scene, n};
    }
    return *one;
}

/// Arguments: scene, edge of the box [voxels], directions, degree of the moments, threads.
void sweeps(benchmark::State& state)
{
    Medium& m = medium(Scene(state.range(0)), int(state.range(1)));
    const int degree = int(state.range(3)), terms = harmonic_count(degree);
    // Scattering of degree 1 takes moments to degree 2 for the closure.
    const Ordinates o = ordinates(OrdinateKind::Product, int(state.range(2)), degree == 2 ? 1 : degree);
    SweepSet set;
    set.source_terms = 4;
    set.moment_terms = terms;
    std::vector<double> y(static_cast<size_t>(terms));
    for (size_t d = 0; d < o.count(); ++d) {
        evaluate_harmonics(degree, o.direction[d], y.data());
        set.direction.push_back(o.direction[d]);
        set.weight.push_back(float(o.weight[d]));
        set.source_basis.insert(set.source_basis.end(), y.begin(), y.begin() + 4);
        set.moment_basis.insert(set.moment_basis.end(), y.begin(), y.end());
        set.inflow.push_back(1.0f);
    }
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, size_t(state.range(4)));
    SweepResult result;
    const SweepFields fields{&m.sigma, &m.source};
    m.sweep->run(set, fields, result);  // finds which rays end in the sky
    for (auto _ : state) m.sweep->run(set, fields, result);
    const double voxels = double(m.index.blocks().active_count());
    state.counters["voxels"] = voxels;
    state.counters["set"] = double(set.count());
    state.counters["fill"] = voxels / double(m.index.blocks().count() * 512);
    state.counters["faces"] = double(m.face_count) / voxels;
    state.counters["bytes"] = double(m.sweep->bytes()) / voxels;
    state.counters["each"] = benchmark::Counter(
        voxels * double(set.count()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(sweeps)
    ->ArgNames({"scene", "edge", "directions", "degree", "threads"})
    ->ArgsProduct({{Cumulus, Fractal}, {64, 128, 256}, {32}, {2}, {1}})
    ->Args({Cumulus, 256, 32, 2, 2})
    ->Args({Cumulus, 128, 256, 2, 1})
    ->Args({Cumulus, 128, 256, 7, 1})
    ->Args({Cumulus, 512, 32, 2, 1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vdbcloud
