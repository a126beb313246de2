#include "vdbcloud/scatter/scatter_plan.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/optics/channels.h"
#include "vdbcloud/optics/mixture.h"
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/channel_groups.h"
#include "vdbcloud/scatter/emission_cost.h"
#include "vdbcloud/scatter/endless_ground.h"
#include "vdbcloud/scatter/harmonics.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/scatter/solid_walls.h"
#include "vdbcloud/scatter/streaming.h"
#include "vdbcloud/sweep/light_lattice.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace vdbcloud {

namespace {

/// Values of the colour channels of a grid that no channel shares: one address for each, the same if all are grey.
std::array<const std::vector<float>*, 3> channels_of(const Vec3SGrid* grid)
{
    static const std::array<std::vector<float>, 3> address;
    if (!grid) return {};
    if (!same_channels(grid)) return {&address[0], &address[1], &address[2]};
    return {&address[0], &address[0], &address[0]};
}

/// Channels as Scattering::groups() joins them.
std::vector<ChannelGroup> groups_of(const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
                                    const std::vector<Light>& lights, const ScatterOptions& o)
{
    const auto tints = channels_of(tint), emissions = channels_of(emission);
    std::array<ChannelInput, 3> input;
    for (int c = 0; c < 3; ++c) {
        ChannelInput& of = input[size_t(c)];
        of.matrix = {medium.sigma_t_per_density[c], medium.albedo[c]};
        of.tint = tints[size_t(c)];
        of.emission = emissions[size_t(c)];
        for (const Light& light : lights) of.light.push_back(light.strength()[c]);
        for (const Vec3d& tone : o.sky.tones()) of.light.push_back(tone[c]);
        of.light.push_back(emission ? 1.0 : 0.0);
        if (o.closure.iterations > 0) of.surfaces = reflectances(o.solids, c);
    }
    return group_channels(input, o.channels_apart);
}

/// Blocks about the surface of solids in which the medium has none.
double wall_blocks(const FloatGrid& density, const ScatterOptions& o)
{
    if (o.solids.empty() || o.closure.iterations == 0) return 0;
    const SolidRays solids(o.solids);
    const SolidSurface surface(density, &solids);
    double count = 0;
    for (const Vec3i& at : surface.blocks)
        count += density.tree().probeConstLeaf(openvdb::Coord(8 * at[0], 8 * at[1], 8 * at[2])) == nullptr;
    return count;
}

/// Voxels with a face outside; no more than `enough` are counted.
double exposed_count(const FloatGrid& density, double enough)
{
    const auto at = density.getConstAccessor();
    double count = 0;
    for (auto v = density.cbeginValueOn(); v && count < enough; ++v) {
        if (!v.isVoxelValue()) continue;
        const openvdb::Coord p = v.getCoord();
        for (int face = 0; face < 6; ++face) {
            openvdb::Coord q = p;
            q[face / 2] += face % 2 ? 1 : -1;
            if (at.isValueOn(q)) continue;
            ++count;
            break;
        }
    }
    return std::min(count, enough);
}

/// How many mediums of one sigma_tr follow one another: each takes a sweep of its own (Scattering::closing).
double closing_mediums(const std::vector<ChannelGroup>& groups, const Medium& medium, bool tinted)
{
    const double g = medium.phase.mean_cosine();
    double count = 0;
    std::array<double, 2> last{};
    for (const ChannelGroup& group : groups) {
        const int c = group.solves[0].channel;
        const std::array<double, 2> own{medium.sigma_t_per_density[c], medium.albedo[c] * g};
        count += count == 0 || own != last || (tinted && g != 0);
        last = own;
    }
    return count;
}

/// How often beams are computed for sweeps (Scattering::add_closed_beams).
double closed_beams(const std::vector<ChannelGroup>& groups, const Medium& medium, const std::vector<Light>& lights,
                    const ScatterOptions& o, bool tinted)
{
    const bool alike = medium.phase.mean_cosine() == 0 && !tinted && !o.heating && !o.flux_map;
    double count = 0;
    std::optional<ChannelBeams> last;
    for (const ChannelGroup& group : groups)
        for (const ChannelGroup::Solve& solve : group.solves) {
            const int c = solve.channel;
            ChannelBeams own{medium.sigma_t_per_density[c], medium.albedo[c], {}};
            for (const Light& light : lights) own.strength.push_back(light.strength()[c]);
            if (alike && last && beams_as(*last, own)) continue;
            last = own;
            ++count;
        }
    return count;
}

struct Counts {
    double solves = 0, groups = 0, at_once = 0, blocks = 0, beams = 0;
    double ground_cells = 0, directions = 0;
    double terms = 1, moments = 1;      // harmonics of the source, and of a sweep's result
    double together = 0, matrices = 0;  // solves that are swept at once, and their matrices: at most
    double followers = 0;               // solves that are swept with one before
    bool sweeps = false, anisotropic = false;
};

/// Rounds that the limiter takes to its change.
constexpr double expected_rounds = 22;

/// What sweeps keep of geometry for each direction [bytes].
constexpr double by_direction = 75e3;

/// What passes between blocks in a sweep [bytes a voxel of the blocks].
double aprons(double directions) { return 3.7 * std::clamp(std::ceil(directions / 8), 1.0, 8.0); }

/// Memory of sweeps, where it is most: in P1's solve before them, in a sweep, or in the balance of cells after it
/// [bytes a voxel of the blocks].
double bytes_of_sweeps(const Counts& n, const ScatterOptions& o, double g)
{
    const double depth = g == 0 ? 8 : 5, pairs = std::clamp(double(o.closure.iterations) - 3, 0.0, depth);
    const double history = double(mixing_bytes(1, g)) * (2 * pairs + 3) / (2 * depth + 3);
    // Matrix and hierarchy, density, extinction, the limit of diffusion, exposed faces.
    const double further = g == 0 ? 11 : 41;  // of a matrix that takes the hierarchy of another
    const double common = 16 + 24 + 12 + 6 + further * (n.matrices - 1);
    // Of each channel: uncollided light; P1's source with its fluxes, which channels that share their beams share, and
    // the fluence from which sweeps start.
    const double uncollided = 4 * n.terms + (g == 0 ? 0 : 4 * n.beams);
    const double start = uncollided + 4 * std::max(n.terms, g == 0 ? 1.0 : 4.0) + 19 + (g == 0 ? 0 : 24);
    const double before = common + n.together * start + (g == 0 ? 24 + 12 : 68);
    // In a sweep moments, a right side, the last excess, fluxes of exposed faces; two moments that no other step takes
    // lie in fields of the solver.
    const double channel = uncollided + 4 * n.moments + 12 + history, lent = o.closure.degree == 1 ? 8 : 0;
    const double swept = n.together * (4 * n.terms + aprons(n.directions)), balanced = 20;
    const double during = common + n.together * channel + std::max(swept, balanced) - lent;
    const double kept = 4 + (n.terms > 1 ? 4 * (n.moments + 3) : 0);  // of a channel that is solved
    return std::max(before, during) + kept * (n.solves - n.together);
}

/// Memory of the arrays [bytes a voxel of the blocks].
double bytes_a_voxel(const Counts& n, const ScatterOptions& o, double g)
{
    // Matrix and hierarchy with their vectors; for each source 8 bytes, and 24 of the flux where it has a part.
    const double matrix = 41 + 4 + 12, source = n.anisotropic ? 32 : 8;
    const double kept = 4 + (n.anisotropic ? 12 : 0);                       // of a channel that is solved
    const double depths = n.groups > 1 && n.beams <= 4 ? 12 * n.beams : 0;  // for the groups that follow
    // The hierarchy is freed before the flux of the last channel.
    double peak = matrix + depths + source * n.at_once + kept * (n.solves - 1) + (n.at_once > 1 ? 28 : 8);
    if (n.sweeps) {
        peak = bytes_of_sweeps(n, o, g);
    } else if (o.flux_map || n.ground_cells > 0) {
        peak += 72 + aprons(n.directions);  // a sweep of degree 1
    } else if (o.limiter) {
        peak += matrix + 28 + source;  // of the limited medium, beside the first
    }
    return peak + (o.heating ? 16 : 0);
}

}  // namespace

double blocks_of(const FloatGrid& density)
{
    const double in_tiles = double(density.activeVoxelCount()) - double(density.tree().activeLeafVoxelCount());
    return double(density.tree().leafCount()) + in_tiles / 512;
}

TreeSize fringed_size(const FloatGrid& density)
{
    TreeSize size = tree_size(density);
    const double blocks = blocks_of(density);
    size.leaves = blocks * (1 + 2.5 / std::cbrt(std::max(8.0, blocks)));
    const auto box = density.evalActiveVoxelBoundingBox();
    // A fringe across the border of a table has another table there.
    for (const auto& [count, bits] : {std::pair{&size.nodes, 7}, {&size.tops, 12}})
        for (int a = 0; a < 3; ++a) {
            const auto tables = [&, b = bits](int by) {
                return double(((int64_t(box.max()[a]) + by) >> b) - ((int64_t(box.min()[a]) - by) >> b) + 1);
            };
            *count *= tables(1) / tables(0);
        }
    return size;
}

double expected_iterations(double extent, double tolerance)
{
    // Of fractal clouds of 64 to 512 voxels: 1.6 to 2.2 iterations for each factor of ten.
    const double each = 0.65 + 0.17 * std::log2(std::max(2.0, extent));
    return std::max(1.0, each * -std::log10(std::min(0.5, tolerance)));
}

double expected_relaxation(double extent, double factor, double tolerance)
{
    const double jacobi = std::cos(pi / (std::max(2.0, extent) + 1)), square = std::pow(factor * jacobi, 2) / 4,
                 rest = square - (factor - 1);
    const double each = rest > 0 ? std::pow(std::sqrt(square) + std::sqrt(rest), 2) : factor - 1;
    return 10 * std::ceil(std::log(std::min(0.5, tolerance)) / std::log(each) / 10);
}

namespace {

/// Media that overlap cost what one tinted medium of the strongest forward scattering costs, and arrays of their own.
ScatterPlan plan_of_parts(const FloatGrid& density, const Vec3SGrid* emission, const std::vector<Light>& lights,
                          const ScatterOptions& o, bool count)
{
    ScatterOptions one = o;
    one.parts.clear();
    const auto scalings = scalings_of(o.parts, 1, true);
    Medium medium = o.parts[0].medium;
    for (const MediumPart& part : o.parts)
        if (part.medium.phase.mean_cosine() > medium.phase.mean_cosine()) medium.phase = part.medium.phase;
    const auto alike = [&](int c) {
        return same_extinction(o.parts, scalings, c, 0) &&
               std::none_of(o.parts.begin(), o.parts.end(),
                            [&](const auto& p) { return p.colour || p.medium.albedo[c] != p.medium.albedo[0]; });
    };
    const bool grey = alike(1) && alike(2);
    if (grey) medium.sigma_t_per_density = medium.albedo = Vec3d(1);
    Vec3SGrid tint(Vec3f(1.0f));
    tint.tree().setValueOn(openvdb::Coord(0), grey ? Vec3f(1.0f) : Vec3f(1.0f, 0.5f, 0.25f));
    ScatterPlan plan = scatter_plan(density, &tint, emission, medium, lights, one, count);
    plan.bytes += plan.voxels * 4 * double(1 + o.parts.size()) * (grey ? 1 : 3);
    return plan;
}

}  // namespace

ScatterPlan scatter_plan(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& o, bool count)
{
    if (!o.parts.empty()) return plan_of_parts(density, emission, lights, o, count);
    ScatterPlan plan;
    const auto box = density.evalActiveVoxelBoundingBox();
    if (box.empty()) return plan;
    check_voxels(density, {o.periodic});
    const auto leaves = double(density.tree().leafCount());
    Counts n;
    n.blocks = blocks_of(density) + wall_blocks(density, o);
    plan.voxels = 512 * n.blocks;
    const auto groups = groups_of(tint, emission, medium, lights, o);
    n.groups = double(groups.size());
    for (const ChannelGroup& group : groups) {
        n.solves += double(group.solves.size());
        n.at_once = std::max(n.at_once, double(group.solves.size()));
    }
    const std::vector<Light> beams = points_of(lights, o.disc_samples);
    n.beams = double(beams.size());
    const Vec3d& extinction = medium.sigma_t_per_density;
    n.sweeps = o.closure.iterations > 0;
    const int degree = n.sweeps ? o.closure.degree : 1;
    const DeltaScaling scaling = o.delta ? delta_scaling(medium.phase, degree) : no_scaling(medium.phase, degree);
    n.anisotropic = medium.phase.mean_cosine() != 0;
    for (const auto& of : swept_together(groups, {extinction[0], extinction[1], extinction[2]}, scaling.delta_f > 0)) {
        double solves = 0;
        for (const ChannelGroup* group : of) solves += double(group->solves.size());
        n.together = std::max(n.together, solves);
        n.matrices = std::max(n.matrices, double(of.size()));
        if (o.periodic == std::array<bool, 3>{} && o.closure.iterations > 0) n.followers += solves - 1;
    }
    n.terms = harmonic_count(scaling.last_degree());
    n.moments = harmonic_count(std::max(degree, 2));
    const bool endless = o.ground_albedo && o.periodic == std::array<bool, 3>{};
    if (n.sweeps || o.flux_map || endless)
        plan.directions = ordinates(o.closure.kind, o.closure.directions, degree).count();
    n.directions = double(plan.directions);

    const double kept = std::min(scaling.last_degree(), o.keep_moments);
    const double higher = kept > 1 ? (n.solves > 1 ? 3 : 1) * (harmonic_count(int(kept)) - 4.0) : 0;
    const TreeSize size = fringed_size(density);
    // phi and its like, of one value a voxel or of three; fluxes.
    const double floats = (n.solves > 1 ? 0 : 1) * (1.0 + o.heating) + higher,
                 vectors = n.solves > 1 ? 1.0 + o.heating : 0, fluxes = n.anisotropic ? (n.solves > 1 ? 3 : 1) : 0;
    plan.value_bytes = size.values(4) * floats + size.values(12) * (vectors + fluxes);
    std::optional<VoxelIndex> index;
    std::optional<EndlessGround> ground;
    TreeSize ground_size;
    if (endless) {
        ground.emplace(index.emplace(density), o.up, *o.ground_albedo, beams, o.sky);
        n.ground_cells = double(ground->patch().cells());
        // A layer of cells in blocks of 8^3, some on each side of the origin.
        ground_size = {n.ground_cells / 64, 4 + n.ground_cells / (128 * 128), 4};
        plan.value_bytes += ground_size.values(12);
    }
    plan.grid_bytes = size.memory(4) * floats + size.memory(12) * (vectors + fluxes);
    plan.grid_bytes += ground_size.memory(12);
    plan.bytes = plan.voxels * bytes_a_voxel(n, o, medium.phase.mean_cosine()) + by_direction * n.directions +
                 (n.sweeps ? 0 : leaves * 4 * 729 * 1.2);
    // The grids are made when matrix and sweeps are gone.
    const double solutions =
        4 * n.solves * (n.anisotropic ? 4.0 : 1.0) + (n.sweeps && n.terms > 1 ? 4 * n.moments * n.solves : 0);
    plan.bytes = std::max(plan.bytes, plan.voxels * (solutions + 8) + plan.grid_bytes);
    if (!count) return plan;

    double extent = 0;
    for (int a = 0; a < 3; ++a) extent = std::max(extent, double(box.dim()[a]));
    const bool relaxes = o.solver == P1Solver::Relaxation && !n.sweeps;
    const double iterations =
        std::min(double(o.solve.max_iterations), relaxes ? expected_relaxation(extent, o.relaxation, o.solve.tolerance)
                                                         : expected_iterations(extent, o.solve.tolerance));
    // Of the limiter's rounds, of fractal clouds of 32 to 128 voxels: each starts from the one before.
    const double limited = o.limiter ? expected_rounds : 0;
    const double sweeps = n.sweeps ? o.closure.iterations : 0, planes = n.sweeps ? 0 : o.flux_map || endless ? 1 : 0;
    const bool patched = endless && !n.sweeps;
    const double rounds = patched && *o.ground_albedo > 0 ? 6 : 1;
    // Solves between sweeps follow the change, which falls to a quarter of the last or so, and the right side with it.
    double later = 0;
    for (int k = 0; k < o.closure.iterations; ++k) {
        const double tolerance = tolerance_between(o.closure, o.solve, std::pow(0.25, k));
        later += expected_iterations(extent, std::min(0.1, 6 * tolerance)) + 0.5;
    }
    // Solves of channels that follow start from those before, and take some 0.6 of the iterations.
    const double solves = n.sweeps && n.together > 1 ? n.solves - 0.4 * (n.together - 1) : n.solves;
    const double first = n.sweeps ? expected_iterations(extent, tolerance_before(o.closure, o.solve)) : iterations;
    const auto voxels = [&](const char* event, double times) { plan.work.add(event, plan.voxels * times); };
    // P1's beams of a group serve its channels; with sweeps each channel adds its own, or that of another. Depths are
    // found once where they are kept (Scattering::keeps_beams).
    const double added = sweeps > 0 ? closed_beams(groups, medium, lights, o, tint != nullptr)
                                    : n.groups + (planes + patched) * n.solves;
    const double found = !tint && n.beams <= 4 ? 1 : added + n.solves * limited;
    voxels("beam_voxel", n.beams * (added + n.solves * limited + found));
    if (o.periodic == std::array<bool, 3>{} && n.beams > 0) {
        const BrickMap bricks(density);
        if (!index) index.emplace(density);
        for (const Light& beam : beams)
            if (const auto to_light = beam->common_direction())
                plan.work.add("lattice_product",
                              found * double(lattice_products(bricks, *to_light,
                                                              beam_offsets(*index, *to_light, sweeps + planes > 0),
                                                              o.rays_per_voxel)));
    }
    voxels("p1_setup_voxel", n.groups + n.solves * limited);
    voxels(relaxes ? "p1_relaxation_voxel" : "p1_iteration_voxel",
           solves * ((1 + 0.5 * (rounds - 1)) * first + later + limited * 0.6 * iterations));
    voxels("p1_channel_voxel", n.solves);
    const double swept = n.solves * (sweeps + rounds * planes) * double(plan.directions);
    if (ground) plan.work.add("ground_ray", n.solves * (1 + patched) * ground->rays());
    if (patched) {
        const double all = std::numeric_limits<double>::infinity();
        plan.work.add("ground_face", n.solves * rounds * exposed_count(density, all) * double(plan.directions));
    }
    const double streamed = sweeps > 0 ? closing_mediums(groups, medium, tint != nullptr) * streaming_directions : 0;
    const double followed = n.followers * sweeps * double(plan.directions);
    voxels("sweep_voxel", swept - followed + streamed);
    voxels("sweep_channel_voxel", followed);
    voxels("sweep_moment_voxel", swept * n.moments + streamed);
    voxels("closure_voxel", n.solves * sweeps);
    plan.work.add("outflow_ray", n.solves * o.reentry_rays);
    if (!o.sky.dark() && o.reentry_rays > 0)
        plan.work.add("outflow_sky_voxel", n.solves * exposed_count(density, o.reentry_rays));
    if (emission) plan.work.add("emission_step", n.solves * emission_steps(density, *emission, o));
    return plan;
}

}  // namespace vdbcloud
