#include "vdbcloud/scatter/series_grids.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/scatter/exposed_beam.h"
#include "vdbcloud/scatter/world_axes.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud {

namespace {

/// A series as a file has it.
struct Series {
    std::vector<FloatGridPtr> basis;
    std::vector<double> albedo, table;  ///< albedos ascending; basis.size() coefficients for each
    Vec3d scale;
};

/// The series of a file. Throws InputError if a part is missing, does not fit the others, or is impossible.
Series read_series(const GridFile& file)
{
    Series series;
    for (size_t k = 0;; ++k) {
        const GridBasePtr grid = find_grid(file, schema::series_phi_name(k));
        const auto phi = grid ? openvdb::gridPtrCast<FloatGrid>(grid) : nullptr;
        if (!phi) break;
        series.basis.push_back(phi);
    }
    if (series.basis.empty())
        throw InputError(file.path + ": no grid 'series_phi_0': expected the output of p1solve --series");
    const MetaMap& first = *series.basis[0];
    series.albedo = get_numbers(first, schema::series_albedo);
    series.table = get_numbers(first, schema::series_table);
    series.scale = get_vector(first, schema::series_scale, Vec3d(1.0));
    const auto& albedo = series.albedo;
    const bool ascend = std::adjacent_find(albedo.begin(), albedo.end(), std::greater_equal<>()) == albedo.end();
    if (albedo.empty() || !ascend || albedo.front() < 0 || albedo.back() > 1)
        throw InputError(file.path + ": grid 'series_phi_0': metadata '" + schema::series_albedo +
                         "' = " + printable(get_text(first, schema::series_albedo, "nothing")) +
                         ": expected ascending numbers in [0, 1]: run p1solve --series again");
    if (series.table.size() != albedo.size() * series.basis.size())
        throw InputError(file.path + ": the series' table of " + std::to_string(series.table.size()) +
                         " numbers does not fit its " + std::to_string(series.basis.size()) + " grids and " +
                         std::to_string(albedo.size()) + " albedos: run p1solve --series again");
    return series;
}

/// Strength of each channel's light relative to channel `c0`: one factor for all lights and the sky.
Vec3d channel_scales(const std::vector<Light>& lights, const Sky& sky, int& c0)
{
    std::vector<Vec3d> strengths = sky.tones();
    for (const Light& light : lights) strengths.push_back(light.strength());
    const auto total = [&](int c) {
        double sum = 0;
        for (const Vec3d& s : strengths) sum += s[c];
        return sum;
    };
    c0 = 0;
    for (int c = 1; c < 3; ++c)
        if (total(c) > total(c0)) c0 = c;
    Vec3d scale(1, 1, 1);
    for (int c = 0; c < 3 && total(c0) > 0; ++c) {
        scale[c] = total(c) / total(c0);
        for (const Vec3d& s : strengths)
            if (std::abs(s[c] - scale[c] * s[c0]) > 1e-9 * total(c0))
                throw InputError("the series serves one colour of light: expected lights and sky of equal tint");
    }
    return scale;
}

/// Events of a series of `orders` orders.
Workload series_work(double voxels, double beams, double orders, double iterations, const SeriesOptions& o)
{
    Workload work;
    const double nodes = o.galerkin ? o.nodes : 0;
    work.add("beam_voxel", voxels * beams * (1 + orders + nodes));
    work.add("p1_setup_voxel", voxels);
    work.add("p1_iteration_voxel", voxels * iterations);
    work.add("series_voxel", voxels * orders * (2 * (orders - 1) + nodes * orders));
    work.add("series_node_voxel", voxels * nodes);
    return work;
}

}  // namespace

ScatterPlan series_plan(const FloatGrid& density, const Medium& medium, const std::vector<Light>& lights,
                        const ScatterOptions& scatter, const SeriesOptions& o, bool raw)
{
    ScatterPlan plan;
    const auto box = density.evalActiveVoxelBoundingBox();
    if (box.empty()) return plan;
    const auto blocks = blocks_of(density);
    const double voxels = 512 * blocks, orders = o.order + 1.0;
    const auto beams = double(points_of(lights, scatter.disc_samples).size());
    const double tolerance = std::min(o.solve.tolerance, series_tolerance);
    plan.work =
        series_work(voxels, beams, orders,
                    orders * expected_iterations(std::max({box.dim()[0], box.dim()[1], box.dim()[2]}), tolerance), o);
    const TreeSize size = fringed_size(density);
    const double grids = orders * (raw ? 2 : 1);
    plan.value_bytes = grids * size.values(4);
    plan.grid_bytes = grids * size.memory(4);
    // Matrix, hierarchy and vectors; the last order with its fluxes; depths of beams; the orders, then as floats too.
    const double forward = medium.phase.mean_cosine() != 0 ? 48 : 0;
    plan.bytes = voxels * (69 + 60 + forward + 16 * beams + 12 * orders + (o.galerkin ? 70 : 0)) + plan.grid_bytes;
    return plan;
}

std::vector<GridBasePtr> series_p1(const FloatGrid& density, const Vec3SGrid* emission, const Medium& medium,
                                   const std::vector<Light>& lights, const ScatterOptions& scatter,
                                   const SeriesOptions& options, bool raw, SeriesReport& report)
{
    if (!medium.grey()) throw InputError("the series serves one extinction: expected equal values of r, g and b");
    const VoxelIndex index(density, {scatter.periodic});
    const auto values = index.gather(density);
    const auto exposed = exposed_voxels(index, values);
    if (values.size() <= 512) return {};
    int c0 = 0;
    const Vec3d scale = channel_scales(lights, scatter.sky, c0);
    SeriesSources sources;
    std::vector<float> glow;
    if (emission) {
        glow = index.gather(*emission, 0);
        for (int c = 1; c < 3; ++c)
            if (scale[c] != 1 || index.gather(*emission, c) != glow)
                throw InputError("the series serves one colour: expected white emission and white lights with it");
        sources.emission = &glow;
    }
    const bool periodic = index.blocks().period() != Vec3i(0, 0, 0);
    const BrickMap bricks(density);
    for (const Light& light : points_of(lights, scatter.disc_samples)) {
        sources.beams.emplace_back(periodic ? periodic_beam_depths(index, exposed, values, light)
                                            : beam_depths(index, exposed, bricks, light, scatter.rays_per_voxel),
                                   light.strength()[c0]);
        add_boxed_depths(index, exposed, values, medium.sigma_t_per_density[0], sources.beams.back().first);
    }
    sources.sky = sky_on_faces(index, scatter.sky, c0);
    const P1Medium channel{medium.sigma_t_per_density[0], 1, nullptr, medium.phase, scatter.delta};
    const AlbedoSeries series = albedo_series(index, values, exposed, channel, sources, options);

    report.work = series_work(512 * double(index.blocks().count()), double(sources.beams.size()), double(series.size()),
                              series.iterations, options);
    report.norm = series.norm;
    report.ratio = series.ratio();
    for (int c = 0; c < 3; ++c) report.estimate[c] = report.ratio * (1 - medium.albedo[c]);
    report.least_albedo = series.albedo.front();
    report.iterations = series.iterations;
    report.converged = series.converged;

    std::vector<GridBasePtr> grids;
    const Sources from = sources_of(density, nullptr, emission);
    const auto add = [&](const auto& grid) {
        write_medium(*grid, medium);
        write_sources(*grid, from);
        grids.push_back(grid);
    };
    for (size_t k = 0; k < series.size(); ++k) {
        add(index.to_grid(series.basis[k].data(), schema::series_phi_name(k)));
        if (!raw) continue;
        std::vector<float> order(series.basis[k].size(), 0.0f);
        for (size_t slot = 0; slot < order.size(); ++slot) {
            double sum = 0;
            for (size_t j = 0; j <= k; ++j) sum += series.map[k * series.size() + j] * double(series.basis[j][slot]);
            order[slot] = float(sum);
        }
        add(index.to_grid(order.data(), schema::series_raw_name(k)));
    }
    MetaMap& first = *grids.front();
    write_delta_scaling(first, scatter.delta ? delta_scaling(medium.phase, 1) : no_scaling(medium.phase, 1));
    set_text(first, schema::lit_by, lights_text(lights));
    write_sky(first, scatter.sky);
    write_periodic(first, scatter.periodic);
    set_numbers(first, schema::series_albedo, series.albedo);
    set_numbers(first, schema::series_table, series.table);
    set_numbers(first, schema::series_map, series.map);
    set_vector(first, schema::series_scale, scale);
    return grids;
}

bool has_series(const GridFile& file, const Sources& sources, const Medium& medium, const std::vector<Light>& lights)
{
    const GridBasePtr first = find_grid(file, schema::series_phi_name(0));
    if (!first) return false;
    const Medium theirs = read_medium(*first);
    const auto close = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(a); };
    return close(theirs.sigma_t_per_density[0], medium.sigma_t_per_density[0]) && medium.grey() &&
           theirs.phase == medium.phase && changed_source(*first, sources).empty() &&
           has_meta(*first, schema::lit_by) && !other_lights(*first, lights);
}

CollidedLight relight(const GridFile& file, const FloatGrid& density, const Vec3SGrid* emission, const Medium& medium,
                      const std::vector<Light>& lights, ScatterOptions options, ScatterReport& report)
{
    const Series series = read_series(file);
    const MetaMap& first = *series.basis[0];
    options.delta = read_delta_scaling(first, medium.phase).delta_f > 0;
    options.sky = read_sky(first).value_or(Sky::constant(Vec3d(0.0)));
    options.periodic = read_periodic(first);
    const auto fluence = [&](const VoxelIndex& index, int channel) {
        const auto c = series_coefficients(series.albedo, series.table, medium.albedo[channel]);
        std::vector<double> sum;
        for (size_t k = 0; k < series.basis.size(); ++k) {
            const auto values = index.gather(*series.basis[k]);
            sum.resize(values.size(), 0.0);
            for (size_t slot = 0; slot < values.size(); ++slot)
                sum[slot] += series.scale[channel] * c[k] * double(values[slot]);
        }
        return sum;
    };
    CollidedLight light = p1_light(density, emission, medium, lights, options, fluence, report);
    if (light.phi) write_accuracy(*light.phi, accuracy_of(report, lights));
    return light;
}

}  // namespace vdbcloud
