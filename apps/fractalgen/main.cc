// fractalgen: a fractal cloud as a density grid, or a fractal mountain as a level set.
//
//   fractalgen --seed 7 -o cloud.vdb
//   fractalgen --envelope slab --coverage 0.4 --roughness 0.1 --bounds -4,0,-4,4,2,4 -o deck.vdb
//   fractalgen cloud.vdb --mountain -o both.vdb
//
// Spectral synthesis of 1/f^beta noise (Voss 1985) shapes the surface of an envelope, by default a cumulus of
// towers.
#include "envelope_grid.h"
#include "estimate.h"
#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>
#include <array>
#include <utility>

using namespace vdbcloud;

namespace {

FloatGridPtr make_mountain(app::App& app, const app::Options& o, const app::Domain& domain)
{
    const auto phase = app.phase("mountain");
    auto grid = mountain_grid(mountain_heights(domain.box, domain.size, o.spectrum, o.relief), o.relief.half_width);
    Workload work = app::least_plan(o, domain).work;
    work.add("mountain_voxel", double(grid->activeVoxelCount()));
    app.add_work(work);
    return grid;
}

/// What to add to places of a domain before it is shaped: places are floats there, so a domain that lies farther from 0
/// than 1000 of its sides is shaped about 0.
Vec3d towards_origin(const Box& box)
{
    const Vec3d sides = box.sides();
    const double longest = std::max({sides[0], sides[1], sides[2]});
    return box.low.length() > 1000 * longest ? -box.low : Vec3d(0);
}

/// The domain and the mask where they are shaped.
std::pair<app::Domain, FloatGridPtr> near_origin(const app::Domain& domain, const FloatGrid* mask)
{
    const Vec3d shift = towards_origin(domain.box);
    app::Domain near = domain;
    near.box = {domain.box.low + shift, domain.box.high + shift};
    FloatGridPtr moved;
    if (mask) {
        moved = FloatGrid::create(std::const_pointer_cast<openvdb::FloatTree>(mask->treePtr()));
        moved->setGridClass(mask->getGridClass());
        moved->setName(mask->getName());
        moved->setTransform(mask->transform().copy());
        moved->transform().postTranslate(shift);
    }
    return {near, moved};
}

FloatGridPtr make_cloud(app::App& app, const app::Options& o, const app::Domain& domain, const FloatGrid* mask,
                        const MetaMap& medium)
{
    CloudBlocks cloud;
    {
        auto phase = app.phase("noise");
        const auto noise = synthesize(domain.size, domain.box.sides(), o.spectrum);
        phase = app.phase("shape");
        const auto [near, moved] = near_origin(domain, mask);
        cloud = shape_cloud(noise, near.box, *envelope_of(o, near, moved.get()), o.shape, app.progress("shape"));
        cloud.domain = domain.box;
    }
    app.add_work(app::work_of(cloud, mask != nullptr));
    const auto phase = app.phase("grid");
    auto density = cloud_grid(cloud);
    density->insertMeta(medium);
    if (density->empty()) app.warnings()("the density is empty: nothing of the envelope is above the threshold");
    return density;
}

/// What detail takes: the result, its noise, and grids like the coarse one.
app::Plan plan_of_detail(const FloatGrid& coarse, const DetailOptions& o)
{
    const double voxels = double(coarse.activeVoxelCount()), fine = voxels * o.factor * o.factor * o.factor;
    app::Plan plan;
    plan.way_out = "a smaller --detail-factor";
    plan.bytes = 4.5 * fine + 6 * 4.5 * voxels + 2 * 128.0 * 128 * 128 * 4;
    plan.work.add("detail_voxel", fine);
    plan.work.add("write_byte", 4 * fine);
    return plan;
}

/// The file of a simulation, with detail in its density.
void run_detail(app::App& app, app::Options& o)
{
    GridFile file = app.read(o.detail_from);
    const FloatGridPtr coarse = app::of_file(file.path, [&] { return density_of(file, {}, app.warnings()); });
    const Vec3SGridPtr velocity = app::vector_grid(app, file, grid_of(file, schema::velocity));
    o.detail.seed = o.seed;
    if (!o.detail_time.given()) o.detail.time = get_number(*file.metadata, schema::sim_time, 0);
    const app::Plan plan = plan_of_detail(*coarse, o.detail);
    if (app.dry_run())
        return app::tell(app, plan, "make a density of " + app::brief(plan.work.of("detail_voxel")) + " voxels");
    app::require_memory(plan);
    FloatGridPtr fine;
    {
        const auto phase = app.phase("detail");
        fine = app::of_file(file.path,
                            [&] { return add_detail(*coarse, velocity.get(), o.detail, app.progress("detail")); });
    }
    Workload work;
    work.add("detail_voxel", plan.work.of("detail_voxel"));
    app.add_work(work);
    app.report()["counts"]["voxels"] = fine->activeVoxelCount();
    app.uses(coarse->getName());
    // Light of the coarse density is none of the fine one.
    remove_grids(file, [](const std::string& name) {
        const schema::GridKind* kind = schema::kind_of(name);
        return kind && kind->result;
    });
    std::replace(file.grids.begin(), file.grids.end(), GridBasePtr(coarse), GridBasePtr(fine));
    app.write(o.output, file);
}

void run(app::App& app, app::Options& o)
{
    if (!o.detail_from.empty()) return run_detail(app, o);
    o.spectrum.seed = o.cumulus.seed = o.seed;
    o.spectrum.beta = o.beta.value_or(o.mountain ? app::mountain_beta : app::cloud_beta);
    o.spectrum.outer = o.outer.value_or(o.mountain ? app::mountain_outer : app::cloud_outer);
    MetaMap medium;
    app::write_given_medium(o.medium, medium);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    if (!o.input.empty()) file = app.read(o.input);
    app::World world(!o.up_asked);
    world.add(o.input, *file.metadata);
    const auto mask = mask_of(app, o, world);
    world.complete(*file.metadata);
    o.up = app::settled_up(app, o.up_asked, file, false);
    o.cumulus.up = o.shape.up = o.relief.up = index_of(o.up);
    const auto domain = domain_of(o, mask ? bounds_around(*mask, o) : default_bounds(o));
    if (app.dry_run()) {
        const auto [near, moved] = near_origin(domain, mask.get());
        const auto [nx, ny, nz] = std::array<int, 3>{domain.size[0], domain.size[1], domain.size[2]};
        const std::string box = std::to_string(nx) + " x " + std::to_string(ny) + " x " + std::to_string(nz);
        return app::tell(app, app::plan_of(o, near, moved.get()), "make a density of " + box + " voxels");
    }
    app::require_memory(app::least_plan(o, domain));

    const auto grid = o.mountain ? make_mountain(app, o, domain) : make_cloud(app, o, domain, mask.get(), medium);
    app.report()["counts"]["voxels"] = grid->activeVoxelCount();
    put_grid(file, grid);
    write_up_axis(*file.metadata, o.up);
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("fractalgen", "A fractal cloud: noise with a power-law spectrum on an envelope, as a density grid.");
    app::Options o;
    app::declare(app, o);
    return app.run(argc, argv, [&] {
        app.each_frame([&](const auto& place) {
            app::Options frame = o;
            for (std::string* path : {&frame.input, &frame.envelope_from, &frame.detail_from, &frame.output})
                place(*path);
            run(app, frame);
        });
    });
}
