#include "vdbcloud/sim/snapshot.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/sim/axes.h"
#include "vdbcloud/sim/run_record.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

namespace {

constexpr double water_density = 1000;  // [kg/m^3]

openvdb::math::Transform::Ptr transform_of(const Axes& axes)
{
    const auto& l = axes.l;
    const Vec3d h = axes.position(l.h[0], l.h[1], l.h[2]),
                c = axes.position(axes.centre(0, 0), axes.centre(1, 0), axes.centre(2, 0));
    openvdb::Mat4R m = openvdb::Mat4R::identity();
    for (const int d : {0, 1, 2}) m(d, d) = h[d], m(3, d) = c[d];
    return openvdb::math::Transform::createLinearTransform(m);
}

/// One value a cell, i fastest, in single precision as grids hold it: half the memory of a large box.
using Cells = std::vector<float>;

Cells gather_cells(const Lattice& l, const std::function<void(int k, double* out)>& plane)
{
    const size_t size = size_t(l.n[0]) * size_t(l.n[1]);
    Cells cells(l.cells());
    std::vector<double> row(size);
    for (int k = 0; k < l.n[2]; ++k) {
        plane(k, row.data());
        for (size_t c = 0; c < size; ++c) cells[size_t(k) * size + c] = float(row[c]);
    }
    return cells;
}

/// Cells within two of one where `values` is above 0.
std::vector<char> near_positive(const Lattice& l, const Cells& values)
{
    std::vector<char> near(values.size());
    for (size_t c = 0; c < values.size(); ++c) near[c] = values[c] > 0;
    const std::array<size_t, 3> stride{1, size_t(l.n[0]), size_t(l.n[0]) * size_t(l.n[1])};
    for (const size_t d : {0, 1, 2}) {
        const std::vector<char> was = near;
        for (size_t c = 0; c < was.size(); ++c) {
            if (!was[c]) continue;
            const int at = int(c / stride[d] % size_t(l.n[d]));
            for (int m = -2; m <= 2; ++m)
                if (at + m >= 0 && at + m < l.n[d]) near[c + size_t(m) * stride[d]] = 1;
        }
    }
    return near;
}

template<typename GridT, typename Value, typename Active>
typename GridT::Ptr fill(const Axes& axes, const std::string& name, const Value& value, const Active& active)
{
    auto grid = GridT::create();
    grid->setName(name);
    grid->setTransform(transform_of(axes));
    auto accessor = grid->getAccessor();
    size_t c = 0;
    for (int k = 0; k < axes.l.n[2]; ++k)
        for (int j = 0; j < axes.l.n[1]; ++j)
            for (int i = 0; i < axes.l.n[0]; ++i, ++c)
                if (active(c)) accessor.setValueOn(openvdb::Coord(axes.voxel(i, j, k)), value(c));
    return grid;
}

FloatGridPtr scalar(const Axes& axes, const std::string& name, const std::string& unit, const Cells& values,
                    const std::function<bool(size_t)>& active)
{
    auto grid = fill<FloatGrid>(
        axes, name, [&](size_t c) { return values[c]; }, active);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    set_text(*grid, schema::unit, unit);
    return grid;
}

void write_extinction(const Simulation& sim, const SnapshotOptions& o, FloatGrid& density)
{
    const Parameters& p = sim.parameters();
    if (!p.moisture) {
        set_vector(density, schema::sigma_t_per_density, Vec3d(o.smoke_extinction));
        set_vector(density, schema::albedo, Vec3d(p.combustion.on ? 0.25 : 0.85));  // soot, pale smoke
        set_number(density, schema::g, 0.5);
    } else {
        const double sigma = 1.5 * p.constants.rho0 / (water_density * o.effective_radius);
        set_vector(density, schema::sigma_t_per_density, Vec3d(sigma));
        set_vector(density, schema::albedo, Vec3d(1.0));
        set_number(density, schema::g, 0.85);
        set_number(density, schema::air_density, p.constants.rho0);
        set_number(density, schema::effective_radius, o.effective_radius);
        set_text(density, schema::extinction_formula,
                 "sigma_t = 3 air_density density / (2 x 1000 kg/m^3 x effective_radius)");
    }
    set_text(density, schema::sigma_t_origin, "given");
    set_text(density, schema::phase, "henyey-greenstein");
}

void write_budget(const Budget& b, MetaMap& meta)
{
    set_number(meta, schema::sim_time, b.time);
    set_number(meta, schema::sim_steps, double(b.steps));
    set_number(meta, schema::sim_w_max, b.w_max);
    set_number(meta, schema::sim_courant, b.courant);
    set_number(meta, schema::sim_water_drift, b.water_drift);
    set_number(meta, schema::sim_theta_drift, b.theta_drift);
    set_number(meta, schema::sim_divergence, b.divergence);
    set_number(meta, schema::sim_cloud_base, b.cloud_base);
    set_number(meta, schema::sim_cloud_top, b.cloud_top);
    set_number(meta, schema::sim_cloud_max, b.cloud_max);
}

}  // namespace

GridFile make_snapshot(const Simulation& sim, const SnapshotOptions& o, const RunRecord& record)
{
    const Lattice& l = sim.parameters().lattice;
    const std::array<double, 2>& frame = sim.parameters().frame;
    const Axes axes{l, o.up, {frame[0] * sim.time(), frame[1] * sim.time()}};
    const auto wanted = [&](const std::string& name) {
        return o.grids.empty() || std::find(o.grids.begin(), o.grids.end(), name) != o.grids.end();
    };
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    write_up_axis(*file.metadata, o.up);
    set_number(*file.metadata, schema::meters_per_unit, 1);
    set_text(*file.metadata, schema::sim_parameters, record.text());
    std::string changes;
    for (const std::string& change : record.changes) changes += change + "\n";
    if (!changes.empty()) set_text(*file.metadata, schema::sim_changes, changes);
    write_budget(sim.budget(), *file.metadata);
    std::ostringstream pressures;
    pressures.precision(9);
    for (const Level& level : sim.column().level) pressures << level.pressure << ' ';
    set_text(*file.metadata, schema::sim_pressure, pressures.str());

    const bool moist = sim.has(Quantity::Water);
    const auto plane_of = [&](Quantity q) {
        return gather_cells(l, [&, q](int k, double* out) { sim.get_plane(q, k, out); });
    };
    Cells density(l.cells(), 0.0f);
    if (moist)
        density = gather_cells(l, [&](int k, double* out) { sim.get_cloud_plane(k, out); });
    else if (sim.has(Quantity::Dye))
        density = plane_of(Quantity::Dye);
    const std::vector<char> near = o.unpruned ? std::vector<char>() : near_positive(l, density);
    const auto nearby = [&](size_t c) { return o.unpruned || near[c]; };
    const auto positive = [&](const Cells& v) { return [&](size_t c) { return o.unpruned || v[c] > 0; }; };

    if (wanted(schema::density)) {
        auto grid = scalar(axes, schema::density, moist ? "kg/kg" : "1", density, positive(density));
        write_extinction(sim, o, *grid);
        file.grids.push_back(grid);
    }
    if (sim.has(Quantity::Theta) && wanted(schema::temperature)) {
        const bool real = sim.thermodynamics().terms().by == SaturationBy::Temperature;
        const bool heated = moist && sim.thermodynamics().terms().latent_heat;
        std::vector<double> cloud(size_t(l.n[0]) * size_t(l.n[1]), 0.0);
        const Cells temperature = gather_cells(l, [&](int k, double* out) {
            const Level& level = sim.column().level[size_t(k)];
            sim.get_plane(Quantity::Theta, k, out);
            if (heated) sim.get_cloud_plane(k, cloud.data());
            for (size_t c = 0; c < cloud.size(); ++c)
                out[c] = (out[c] + level.heat * cloud[c]) * (real ? level.exner : 1);
        });
        file.grids.push_back(scalar(axes, schema::temperature, "K", temperature, nearby));
    }
    if (moist && wanted(schema::water))
        file.grids.push_back(scalar(axes, schema::water, "kg/kg", plane_of(Quantity::Water), nearby));
    if (sim.has(Quantity::Rain) && wanted(schema::rain)) {
        const Cells rain = plane_of(Quantity::Rain);
        file.grids.push_back(scalar(axes, schema::rain, "kg/kg", rain, positive(rain)));
    }
    if (sim.has(Quantity::Dye) && wanted(schema::dye)) {
        const Cells dye = plane_of(Quantity::Dye);
        file.grids.push_back(scalar(axes, schema::dye, "1", dye, positive(dye)));
    }
    if (sim.has(Quantity::Fuel) && wanted(schema::flame)) {
        const Cells flame = gather_cells(l, [&](int k, double* out) { sim.get_flame_plane(k, out); });
        file.grids.push_back(scalar(axes, schema::flame, "K/s", flame, positive(flame)));
    }
    if (wanted(schema::velocity)) {
        const auto component = [&](Quantity q) { return sim.has(q) ? plane_of(q) : Cells(l.cells(), 0.0f); };
        const Cells u = component(Quantity::U), v = component(Quantity::V), w = component(Quantity::W);
        auto grid = fill<Vec3SGrid>(
            axes, schema::velocity, [&](size_t c) { return axes.vector(u[c], v[c], w[c]); }, nearby);
        grid->setGridClass(openvdb::GRID_STAGGERED);
        set_text(*grid, schema::unit, "m/s");
        file.grids.push_back(grid);
    }
    return file;
}

}  // namespace vdbcloud::sim
