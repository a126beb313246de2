// The P1 solver against hypre's conjugate gradients with the best of some settings of BoomerAMG on the same matrix, its
// growth with the grid, memory and threads. Seconds are processor seconds of the process; all ratios are of one run.
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/scatter/p1_problem.h"

#include "support/fields.h"
#include "support/size.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#ifdef VDBCLOUD_HAS_HYPRE
#include <HYPRE.h>
#include <HYPRE_parcsr_ls.h>
#include <mpi.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <string>

namespace vdbcloud {
namespace {

/// A thresholded fractal cloud of n^3 voxels about a fifth of which are active, 40 mean free paths thick; with a floor
/// all are, and coefficients jump by some 1e3.
FloatGridPtr cloud(int n, float floor)
{
    Spectrum spectrum;
    spectrum.seed = 3;
    spectrum.beta = 4.2;
    const auto noise = synthesize(Vec3i(n), Vec3d(1), spectrum);
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0 / n));
    auto accessor = grid->getAccessor();
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z) {
                const float v = std::min(1.0f, 3 * (noise(x, y, z) - 0.8f));
                if (v > 0 || floor > 0) accessor.setValueOn(openvdb::Coord(x, y, z), std::max(floor, v));
            }
    return grid;
}

struct Problem {
    Problem(int n, float floor)
        : grid(cloud(n, floor)), index(*grid), density(index.gather(*grid)), exposed(exposed_voxels(index, density)),
          p1(index, density, exposed, {40, 0.999, nullptr, PhaseFunction::henyey_greenstein(0), true})
    {
    }
    /// Isotropic emission in proportion to density, as the first scattering of a veiled sun would be.
    std::vector<double> rhs() const
    {
        P1Source source(p1);
        add_emission(p1, density, 1, source);
        return std::move(source.rhs);
    }
    FloatGridPtr grid;
    VoxelIndex index;
    std::vector<float> density;
    std::vector<ExposedVoxel> exposed;
    P1Operator p1;
};

double cpu_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }
double wall_seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Cost {
    double cpu = 0, wall = 0;
    int iterations = 0;
    double residual = 0;
    size_t bytes = 0;
    std::vector<double> x;
};

Cost ours(const Problem& problem)
{
    auto b = problem.rhs();
    Cost cost;
    const double cpu = cpu_seconds(), wall = wall_seconds();
    Multigrid multigrid(problem.p1.stencil());
    const auto result = conjugate_gradient(problem.p1.stencil(), multigrid, b, cost.x);
    cost.cpu = cpu_seconds() - cpu;
    cost.wall = wall_seconds() - wall;
    cost.iterations = result.iterations;
    cost.residual = result.residual;
    cost.bytes = problem.p1.stencil().bytes() + multigrid.bytes() + 20 * problem.index.blocks().slots();
    return cost;
}

#ifdef VDBCLOUD_HAS_HYPRE
/// Settings of BoomerAMG for three dimensions: all with extended+i interpolation of four elements a row.
struct HypreSettings {
    const char* name;
    HYPRE_Int coarsening, aggressive_levels;
    double threshold;
};
constexpr HYPRE_Int pmis = 8, hmis = 10;
constexpr HypreSettings hypre_settings[] = {{"PMIS, threshold 0.25", pmis, 0, 0.25},
                                            {"PMIS, threshold 0.5", pmis, 0, 0.5},
                                            {"HMIS, threshold 0.25", hmis, 0, 0.25},
                                            {"HMIS, threshold 0.5", hmis, 0, 0.5},
                                            {"HMIS, one aggressive level, threshold 0.25", hmis, 1, 0.25},
                                            {"HMIS, one aggressive level, threshold 0.5", hmis, 1, 0.5}};

/// Setup and solve, from 0.
Cost hypre_with(const HypreSettings& settings, HYPRE_ParCSRMatrix A, HYPRE_ParVector B, HYPRE_ParVector X)
{
    HYPRE_ParVectorSetConstantValues(X, 0);
    Cost cost;
    const double cpu = cpu_seconds(), wall = wall_seconds();
    HYPRE_Solver pcg, amg;
    HYPRE_ParCSRPCGCreate(MPI_COMM_WORLD, &pcg);
    HYPRE_PCGSetTol(pcg, 1e-6);
    HYPRE_PCGSetMaxIter(pcg, 200);
    HYPRE_PCGSetTwoNorm(pcg, 1);
    HYPRE_BoomerAMGCreate(&amg);
    HYPRE_BoomerAMGSetCoarsenType(amg, settings.coarsening);
    HYPRE_BoomerAMGSetAggNumLevels(amg, settings.aggressive_levels);
    HYPRE_BoomerAMGSetInterpType(amg, 6);
    HYPRE_BoomerAMGSetPMaxElmts(amg, 4);
    HYPRE_BoomerAMGSetStrongThreshold(amg, settings.threshold);
    HYPRE_BoomerAMGSetRelaxType(amg, 6);
    HYPRE_BoomerAMGSetTol(amg, 0);
    HYPRE_BoomerAMGSetMaxIter(amg, 1);
    HYPRE_PCGSetPrecond(pcg, reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSolve),
                        reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSetup), amg);
    HYPRE_ParCSRPCGSetup(pcg, A, B, X);
    HYPRE_ParCSRPCGSolve(pcg, A, B, X);
    cost.cpu = cpu_seconds() - cpu;
    cost.wall = wall_seconds() - wall;
    HYPRE_Int iterations = 0;
    HYPRE_PCGGetNumIterations(pcg, &iterations);
    HYPRE_PCGGetFinalRelativeResidualNorm(pcg, &cost.residual);
    cost.iterations = int(iterations);
    HYPRE_BoomerAMGDestroy(amg);
    HYPRE_ParCSRPCGDestroy(pcg);
    return cost;
}

/// The least of `hypre_settings` that reach the tolerance, on the same matrix and right-hand side.
Cost hypre(const Problem& problem, std::string& best)
{
    static const bool started = [] {
        MPI_Init(nullptr, nullptr);
        HYPRE_Init();
        return true;
    }();
    (void)started;
    const Blocks& blocks = problem.index.blocks();
    const Stencil& a = problem.p1.stencil();
    const auto b = problem.rhs();
    std::vector<HYPRE_BigInt> number(blocks.slots(), -1), slots;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) {
            number[slot] = HYPRE_BigInt(slots.size());
            slots.push_back(HYPRE_BigInt(slot));
        }
    const HYPRE_BigInt n = HYPRE_BigInt(slots.size());
    HYPRE_IJMatrix matrix;
    HYPRE_IJVector right, left;
    HYPRE_IJMatrixCreate(MPI_COMM_WORLD, 0, n - 1, 0, n - 1, &matrix);
    HYPRE_IJMatrixSetObjectType(matrix, HYPRE_PARCSR);
    HYPRE_IJMatrixInitialize(matrix);
    for (auto* v : {&right, &left}) {
        HYPRE_IJVectorCreate(MPI_COMM_WORLD, 0, n - 1, v);
        HYPRE_IJVectorSetObjectType(*v, HYPRE_PARCSR);
        HYPRE_IJVectorInitialize(*v);
    }
    for (HYPRE_BigInt row = 0; row < n; ++row) {
        const size_t slot = size_t(slots[size_t(row)]);
        HYPRE_BigInt columns[7] = {row};
        double values[7] = {a.extra[slot]};
        HYPRE_Int count = 1;
        for (int face = 0; face < 6; ++face) {
            const size_t to = blocks.neighbour(slot, face);
            if (!blocks.active(to)) continue;
            const double c = a.face[face / 2][face % 2 ? slot : to];
            values[0] += c;
            columns[count] = number[to];
            values[count++] = -c;
        }
        const double value = b[slot], zero = 0;
        HYPRE_IJMatrixSetValues(matrix, 1, &count, &row, columns, values);
        HYPRE_IJVectorSetValues(right, 1, &row, &value);
        HYPRE_IJVectorSetValues(left, 1, &row, &zero);
    }
    HYPRE_IJMatrixAssemble(matrix);
    HYPRE_IJVectorAssemble(right);
    HYPRE_IJVectorAssemble(left);
    HYPRE_ParCSRMatrix A;
    HYPRE_ParVector B, X;
    HYPRE_IJMatrixGetObject(matrix, reinterpret_cast<void**>(&A));
    HYPRE_IJVectorGetObject(right, reinterpret_cast<void**>(&B));
    HYPRE_IJVectorGetObject(left, reinterpret_cast<void**>(&X));

    Cost cost;
    for (const HypreSettings& settings : hypre_settings) {
        const Cost now = hypre_with(settings, A, B, X);
        if (now.residual > 1e-6 || (cost.cpu > 0 && now.cpu >= cost.cpu)) continue;
        cost = now;
        best = settings.name;
    }
    HYPRE_IJMatrixDestroy(matrix);
    HYPRE_IJVectorDestroy(right);
    HYPRE_IJVectorDestroy(left);
    return cost;
}
#endif

/// The whole box of n^3 cells, thin medium about the cloud: where an algebraic multigrid is at home.
void box(benchmark::State& state)
{
    const Problem problem(int(state.range(0)), 1e-3f);
    const double cells = double(problem.index.blocks().active_count());
    for (auto _ : state) {
        const Cost mine = ours(problem);
        state.counters["ns_per_cell"] = 1e9 * mine.cpu / cells;
        state.counters["iterations"] = mine.iterations;
#ifdef VDBCLOUD_HAS_HYPRE
        std::string best;
        const Cost theirs = hypre(problem, best);
        state.SetLabel(best);
        state.counters["hypre_ns_per_cell"] = 1e9 * theirs.cpu / cells;
        state.counters["hypre_iterations"] = theirs.iterations;
        state.counters["hypre_over_ours"] = theirs.cpu / mine.cpu;
#endif
    }
}

/// The cloud alone on its active voxels; hypre gets the same sparse matrix, and the box about it.
void sparse(benchmark::State& state)
{
    const int n = int(state.range(0));
    const Problem problem(n, 0);
    const double cells = double(problem.index.blocks().active_count());
    for (auto _ : state) {
        const Cost mine = ours(problem);
        state.counters["voxels"] = cells;
        state.counters["fill"] = cells / double(512 * problem.index.blocks().count());
        state.counters["iterations"] = mine.iterations;
        state.counters["ns_per_voxel"] = 1e9 * mine.cpu / cells;
        state.counters["bytes_per_voxel"] = double(mine.bytes) / cells;
#ifdef VDBCLOUD_HAS_HYPRE
        if (state.range(1)) {
            std::string in_box, on_voxels;
            state.counters["hypre_box_over_ours"] = hypre(Problem(n, 1e-3f), in_box).cpu / mine.cpu;
            state.counters["hypre_over_ours"] = hypre(problem, on_voxels).cpu / mine.cpu;
            state.SetLabel("box: " + in_box + "; voxels: " + on_voxels);
        }
#endif
    }
}

/// Seconds on one thread over seconds on two.
void threads(benchmark::State& state)
{
    const Problem problem(int(state.range(0)), 0);
    for (auto _ : state) {
        double seconds[2];
        for (int k : {0, 1}) {
            tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(k + 1));
            seconds[k] = std::min(ours(problem).wall, ours(problem).wall);
        }
        state.counters["two_threads_over_one"] = seconds[0] / seconds[1];
    }
}

BENCHMARK(box)->Arg(64)->Arg(112)->Iterations(1)->Unit(benchmark::kSecond);
BENCHMARK(sparse)
    ->Args({64, 0})
    ->Args({128, 1})
    ->Args({256, test::full_size()})
    ->Iterations(1)
    ->Unit(benchmark::kSecond);
BENCHMARK(threads)->Arg(128)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace vdbcloud
