// Particles, splatted.
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/particles.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/tree_size.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

Particles read(const Options& o)
{
    const ParticleNames names = pairs_of("--variable", o.variables);
    const auto& roles = particle_roles();
    for (const auto& [role, name] : names)
        if (std::find(roles.begin(), roles.end(), role) == roles.end())
            throw UsageError("--variable " + printable(role + "=" + name) + ": no role '" + printable(role) +
                             "' of particles: see --help");
    if (o.is(Format::Ply)) return read_ply(o.input, names);
    return o.is(Format::Csv) ? read_csv(o.input, names) : read_points(o.input, names);
}

/// Size of a voxel: --cell, else cubes of half the median radius.
Vec3d cell_of(app::App& app, const Options& o, const Particles& particles)
{
    if (o.option.cell.given()) return o.cell;
    std::vector<float> radii = particles.radius;
    double median = o.radius;
    if (!radii.empty()) {
        const auto middle = radii.begin() + std::ptrdiff_t(radii.size() / 2);
        std::nth_element(radii.begin(), middle, radii.end());
        median = double(*middle);
    }
    if (!(median > 0))
        throw UsageError(
            "--cell is missing: the particles have no radius above 0, so --cell DX,DY,DZ has to say the size "
            "of a voxel, or --radius the radius of a particle");
    app.say("voxels of " + app::brief(median / 2) + ", half the median radius, assumed (--cell)");
    return Vec3d(median / 2);
}

app::Plan plan_of(const Particles& particles, const SplatWork& work)
{
    app::Plan plan;
    const double floats = 1 + (particles.temperature.empty() ? 0 : 1) + (particles.velocity.empty() ? 0 : 3);
    const TreeSize size{work.blocks, work.nodes, 1};
    plan.way_out = "larger cells (--cell)";
    plan.bytes = floats * size.memory(4) + 16 * work.pairs + 8 * double(particles.position.size());
    plan.work.add("table_cell", 512 * work.blocks);
    plan.work.add("splat_voxel", work.voxels);
    plan.work.add("write_byte", floats * size.values(4));
    return plan;
}

void say_mass(app::App& app, const Splats& splats, const Particles& particles, const Vec3d& cell)
{
    double sum = 0;
    for (auto v = splats.density->cbeginValueOn(); v; ++v) sum += double(*v) * double(v.getVoxelCount());
    sum *= cell[0] * cell[1] * cell[2];
    app.report()["particles"] = {{"count", particles.position.size()}, {"mass", splats.mass}, {"mass_of_grid", sum}};
    const char* const mass = !particles.mass.empty()      ? "mass of each particle"
                             : !particles.density.empty() ? "mass: density times the volume of the ball"
                                                          : "mass 1 each, assumed";
    app.say(std::to_string(particles.position.size()) + " particles, " + mass + ": " + app::brief(splats.mass) +
            " together, " + app::brief(sum) + " in " + std::to_string(splats.density->activeVoxelCount()) + " voxels");
}

}  // namespace

void import_particles(app::App& app, const Options& o)
{
    const Particles particles = read(o);
    o.option.radius.check_effect(particles.radius.empty(), "particles without a radius of their own");
    const SplatOptions options{cell_of(app, o, particles), o.radius};
    const SplatWork work = splat_work(particles, options);
    const app::Plan plan = plan_of(particles, work);
    if (ended(app, plan, std::to_string(particles.position.size()) + " particles")) return;
    Workload splatted;
    splatted.add("splat_voxel", work.voxels);
    app.add_work(splatted);
    const Splats splats = splat(particles, options);
    splats.density->setName(schema::density);
    std::vector<GridBasePtr> grids{splats.density};
    if (splats.temperature) {
        splats.temperature->setName(schema::temperature);
        grids.push_back(splats.temperature);
    }
    if (splats.velocity) {
        splats.velocity->setName(schema::velocity);
        grids.push_back(splats.velocity);
    }
    say_mass(app, splats, particles, options.cell);
    if (particles.radius.empty())
        app.say(o.radius > 0 ? "radius " + app::brief(o.radius) : "no radius: each particle goes to eight voxels");
    const UpAxis up = o.up.value_or(UpAxis::Y);
    app.say(std::string("up axis ") + (up == UpAxis::Z ? "z" : "y") + (o.up ? "" : ", assumed (--up)") +
            "; density is mass per volume" +
            (o.medium.option.extinction.given() ? "" : ", extinction left to later programs"));
    if (splats.density->empty()) app.warnings()(printable(o.input) + ": no mass: the density is empty");
    write_import(app, o, o.output, grids, up, o.meters_per_unit, false);
}

}  // namespace vdbcloud
