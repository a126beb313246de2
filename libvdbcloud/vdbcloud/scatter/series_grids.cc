#include "vdbcloud/scatter/series_grids.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/sources.h"

#include "vdbcloud/scatter/world_axes.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

std::string text_of(const std::vector<double>& v)
{
    std::ostringstream text;
    text.precision(17);
    for (size_t k = 0; k < v.size(); ++k) text << (k ? " " : "") << v[k];
    return text.str();
}

std::vector<double> numbers_of(const std::string& text)
{
    std::istringstream in(text);
    std::vector<double> v;
    for (double x; in >> x;) v.push_back(x);
    return v;
}

/// Strength of each channel's light relative to channel `c0`: one factor for all lights and the sky.
Vec3d channel_scales(const std::vector<Light>& lights, const Sky& sky, int& c0)
{
    std::vector<Vec3d> strengths{sky.zenith, sky.horizon, sky.ground};
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

}  // namespace

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
    for (const Light& light : points_of(lights, scatter.disc_samples))
        sources.beams.emplace_back(periodic ? periodic_beam_depths(index, exposed, values, light)
                                            : beam_depths(index, exposed, bricks, light, scatter.rays_per_voxel),
                                   light.strength()[c0]);
    sources.sky = sky_on_faces(index, scatter.sky, c0);
    const P1Medium channel{medium.sigma_t_per_density[0], 1, nullptr, medium.phase, scatter.delta};
    const AlbedoSeries series = albedo_series(index, values, exposed, channel, sources, options);

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
        if (k < series.flux.size()) {
            const auto flux = flux_in_world(index, series.flux[k]);
            add(index.to_grid({flux[0].data(), flux[1].data(), flux[2].data()}, schema::series_flux_name(k)));
        }
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
    set_text(first, schema::series_albedo, text_of(series.albedo));
    set_text(first, schema::series_table, text_of(series.table));
    set_text(first, schema::series_map, text_of(series.map));
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
           get_text(*first, schema::lit_by, "") == lights_text(lights);
}

CollidedLight relight(const GridFile& file, const Medium& medium, const std::vector<Light>& lights,
                      const std::vector<GridBasePtr>& transmittance)
{
    std::vector<FloatGridPtr> basis;
    std::vector<Vec3SGridPtr> gradients;
    for (size_t k = 0;; ++k) {
        const auto grid = find_grid(file, schema::series_phi_name(k));
        const auto phi = grid ? openvdb::gridPtrCast<FloatGrid>(grid) : nullptr;
        if (!phi) break;
        basis.push_back(phi);
        const auto flux = find_grid(file, schema::series_flux_name(k));
        if (const auto found = flux ? openvdb::gridPtrCast<Vec3SGrid>(flux) : nullptr) gradients.push_back(found);
    }
    if (basis.empty())
        throw InputError(file.path + ": no grid 'series_phi_0': expected the output of p1solve --series");
    const MetaMap& first = *basis[0];
    const auto albedo = numbers_of(get_text(first, schema::series_albedo, "")),
               table = numbers_of(get_text(first, schema::series_table, ""));
    if (table.size() != albedo.size() * basis.size())
        throw InputError(file.path + ": the series' table of " + std::to_string(table.size()) +
                         " numbers does not fit its " + std::to_string(basis.size()) + " grids");
    const Vec3d scale = get_vector(first, schema::series_scale, Vec3d(1.0));
    const DeltaScaling scaling = read_delta_scaling(first, medium.phase);
    const double g = medium.phase.mean_cosine(), f = scaling.delta_f;
    std::vector<double> c[3];
    for (int channel = 0; channel < 3; ++channel)
        c[channel] = series_coefficients(albedo, table, medium.albedo[channel]);

    CollidedLight light;
    light.scaling = scaling;
    const auto like_basis = [&] {
        auto grid = Vec3SGrid::create(Vec3f(0.0f));
        grid->setTree(std::make_shared<openvdb::Vec3STree>(basis[0]->tree(), Vec3f(0.0f), openvdb::TopologyCopy()));
        grid->setTransform(basis[0]->transform().copy());
        return grid;
    };
    std::vector<FloatGrid::ConstAccessor> at;
    for (const auto& grid : basis) at.push_back(grid->getConstAccessor());
    const auto phi = like_basis();
    light.phi = phi;
    for (auto v = phi->beginValueOn(); v; ++v) {
        Vec3d sum(0, 0, 0);
        for (size_t k = 0; k < basis.size(); ++k) {
            const double value = at[k].getValue(v.getCoord());
            for (int channel = 0; channel < 3; ++channel) sum[channel] += c[channel][k] * value;
        }
        v.setValue(Vec3f(sum * scale));
    }
    const auto stamp = [&](GridBase& grid) {
        for (auto m = first.beginMeta(); m != first.endMeta(); ++m)
            if (m->first.rfind("vdbcloud:", 0) == 0 && m->first.rfind("vdbcloud:series", 0) != 0)
                grid.insertMeta(m->first, *m->second);
        write_medium(grid, medium);
    };
    if (scaling.mean_cosine() == 0 || gradients.size() != basis.size()) {
        name_collided_light(light, stamp);
        return light;
    }

    light.flux_limit = longest_flux;
    std::vector<Vec3SGrid::ConstAccessor> slopes;
    for (const auto& grid : gradients) slopes.push_back(grid->getConstAccessor());
    for (int channel = 0; channel < 3; ++channel) {
        const double w0 = medium.albedo[channel], ratio = (1 - g) / (1 - w0 * g), q = w0 * (g - f) / (1 - w0 * g);
        const auto flux = light.flux[size_t(channel)] = like_basis();
        for (auto v = flux->beginValueOn(); v; ++v) {
            Vec3d sum(0, 0, 0);
            for (size_t k = 0; k < slopes.size(); ++k)
                sum += (c[channel][k] * ratio * scale[channel]) * Vec3d(slopes[k].getValue(v.getCoord()));
            for (size_t l = 0; l < lights.size() && l < transmittance.size(); ++l) {
                double t = 1;
                if (const auto grey = openvdb::gridPtrCast<FloatGrid>(transmittance[l]))
                    t = grey->tree().getValue(v.getCoord());
                else if (const auto rgb = openvdb::gridPtrCast<Vec3SGrid>(transmittance[l]))
                    t = rgb->tree().getValue(v.getCoord())[channel];
                const Vec3d x = basis[0]->transform().indexToWorld(v.getCoord());
                const Sight sight = lights[l]->towards(x);
                if (!(sight.distance > 0)) continue;  // the light is at the voxel: no direction
                const double irradiance = lights[l].strength()[channel] * lights[l]->irradiance(x);
                sum -= (q * irradiance * t) * sight.direction;
            }
            v.setValue(Vec3f(sum));
        }
    }
    name_collided_light(light, stamp);
    return light;
}

}  // namespace vdbcloud
