// vdbimport: a density grid from what other programs write: tables of optical depths, media of boxes, and fields of
// cloud models.
//
//   vdbimport radar.txt --cell 50,50,45 -o radar.vdb
//   vdbimport depth.txt --thickness thickness.txt --thickness-unit 1000 --cell 30,30,30 --base 200 -o scene.vdb
//   vdbimport duct.txt --boxes --cell 2,2,2 -o duct.vdb
//   vdbimport les.nc -o les.%04d.vdb
//
// The grid of tables and fields of models holds extinction: sigma_t is density times 1, unless --extinction says
// otherwise.
#include "frames.h"
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/tree_size.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

app::Plan plan_of_voxels(double voxels, double floats, double held, const std::string& way_out)
{
    app::Plan plan;
    const double leaves = std::ceil(voxels / 512), nodes = std::ceil(leaves / 4096), tops = std::ceil(nodes / 32768);
    const TreeSize size{leaves, nodes, tops};
    plan.way_out = way_out;
    plan.bytes = held + floats * size.memory(4);
    plan.work.add("table_cell", voxels);
    plan.work.add("write_byte", floats * size.values(4));
    return plan;
}

bool ended(app::App& app, const app::Plan& plan, const std::string& what)
{
    if (app.dry_run())
        return app::tell(app, plan, "make up to " + app::brief(plan.work.of("table_cell")) + " voxels of " + what),
               true;
    app::require_memory(plan);
    Workload cells;
    cells.add("table_cell", plan.work.of("table_cell"));
    app.add_work(cells);
    return false;
}

void write_import(app::App& app, const Options& o, const std::string& path, const std::vector<GridBasePtr>& grids,
                  UpAxis up, double meters_per_unit, bool extinction)
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = grids;
    GridBase& density = *grids.front();
    const std::vector<app::Option> medium = app::options_of(o.medium);
    const bool given = std::any_of(medium.begin(), medium.end(), [](const app::Option& m) { return m.given(); });
    if (extinction) {
        set_vector(density, schema::sigma_t_per_density, Vec3d(1.0));
        set_text(density, schema::sigma_t_origin, "given");
        const bool keeps = o.medium.option.albedo.given() || has_meta(density, schema::albedo);
        if (given) app::chosen_medium(app, o.medium, dynamic_cast<FloatGrid&>(density), /*burns=*/false);
        if (!keeps) density.removeMeta(schema::albedo);  // that of soot, if it burns
    } else {
        app::write_given_medium(o.medium, density);
    }
    app.report()["counts"]["voxels"] = density.activeVoxelCount();
    write_up_axis(*file.metadata, up);
    if (meters_per_unit > 0) set_number(*file.metadata, schema::meters_per_unit, meters_per_unit);
    app.write(path, file);
}

namespace {

void import(app::App& app, const Options& o)
{
    const Format kind = o.kind();
    if (kind != Format::NetCdf) app::require_placed(o.output);
    switch (kind) {
    case Format::NetCdf: return import_model(app, o);
    case Format::Npy:
    case Format::Raw: return import_array(app, o);
    case Format::Shdom: return import_properties(app, o);
    case Format::Ply:
    case Format::Csv:
    case Format::Points: return import_particles(app, o);
    case Format::NanoVdb: return import_nanovdb(app, o);
    default: return import_table(app, o);
    }
}

}  // namespace

}  // namespace vdbcloud

int main(int argc, char** argv)
{
    using namespace vdbcloud;
    app::App app("vdbimport", "A density grid from a table, or from a field of a cloud model in netCDF.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] {
        std::string written;
        app.each_frame([&](const app::App::PlaceFrame& place) {
            Options frame = o;
            place(frame.input);
            place(frame.output);
            app::require_numbered(frame.output, written);
            import(app, frame);
        });
    });
}
