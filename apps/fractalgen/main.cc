// fractalgen: a fractal cloud as a density grid, or a fractal mountain as a level set.
//
//   fractalgen --seed 7 -o cloud.vdb
//   fractalgen --envelope slab --coverage 0.4 --roughness 0.1 --bounds -4,0,-4,4,2,4 -o deck.vdb
//   fractalgen cloud.vdb --mountain -o both.vdb
//
// Spectral synthesis of 1/f^beta noise (Voss 1985) shapes the surface of an envelope, by default a cumulus of
// towers.
#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/fractal/mask_envelope.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>
#include <cmath>

using namespace vdbcloud;
using app::Region;

namespace {

/// How far beyond the envelope noise carries the cloud [fraction of the longest side].
double reach(const app::Options& o) { return 3 * (o.shape.warp + (o.shape.coverage ? 0 : o.shape.roughness)); }

double longest(const Box& box) { return std::max({box.sides()[0], box.sides()[1], box.sides()[2]}); }

/// The envelope within the domain, with room around it for what noise adds.
EnvelopePtr envelope_of(const app::Options& o, const app::Domain& domain, const FloatGrid* mask)
{
    if (mask) return mask_envelope(*mask, domain.box, domain.size);
    const Vec3d sides = domain.box.sides();
    const double shortest = std::min({sides[0], sides[1], sides[2]});
    Box box = domain.box.inset(std::min(reach(o) * longest(domain.box), shortest / 4));
    switch (o.envelope) {
    case Region::Sphere: return sphere_envelope(box);
    case Region::Ellipsoid: return ellipsoid_envelope(box);
    case Region::Box: return box_envelope(box);
    case Region::Slab: return slab_envelope(box, index_of(o.up));
    case Region::Cumulus: break;
    }
    box.low[index_of(o.up)] = domain.box.low[index_of(o.up)];  // a flat base needs no room
    return cumulus_envelope(box, o.cumulus);
}

/// The grid of --envelope-from: the one that is named, else a density, else a level set. Null without a file.
FloatGridPtr mask_of(app::App& app, const app::Options& o)
{
    if (o.envelope_from.empty()) return nullptr;
    GridFile file = app.read(o.envelope_from);
    GridBasePtr surface;
    for (const auto& grid : file.grids)
        if (!surface && grid->getGridClass() == openvdb::GRID_LEVEL_SET) surface = grid;
    if (!o.mask_grid.empty()) {
        const auto named = find_grid(file, o.mask_grid);
        surface = named && named->getGridClass() == openvdb::GRID_LEVEL_SET ? named : nullptr;
    } else if (grid_of(file, schema::density)) {
        surface = nullptr;
    }
    if (!surface) return density_of(file, o.mask_grid, app.warnings());
    if (const auto grid = openvdb::gridPtrCast<FloatGrid>(surface)) return grid;
    throw InputError(o.envelope_from + ": level set '" + surface->getName() + "' is not of floats");
}

Box bounds_around(const FloatGrid& mask, const app::Options& o)
{
    const Box box = mask_bounds(mask);
    return box.inset(-std::min(reach(o), 0.5) * longest(box));
}

void write_flags(const app::Options& o, FloatGrid& density)
{
    const bool extinction = o.extinction.given();
    if (!extinction && !o.albedo.given() && !o.g.given()) return;
    write_medium(density, o.medium);
    if (extinction)
        set_text(density, schema::sigma_t_origin, "given");
    else
        density.removeMeta(schema::sigma_t_per_density);
}

/// Bytes at the peak: the noise, the distances of a mask, and at most as much as the noise for the blocks and
/// the grid.
void estimate(app::App& app, const app::Options& o, const app::Domain& domain)
{
    const double voxels = double(domain.size[0]) * domain.size[1] * domain.size[2];
    const double fields = o.mountain ? 0.2 : o.envelope_from.empty() ? 2 : 3.25;
    const double bytes = fields * double(fft::RealField<float>::bytes(domain.size)), seconds = 3e-8 * voxels;
    app.report()["estimate"] = {{"memory_bytes", bytes}, {"seconds", seconds}};
    app.say(std::to_string(domain.size[0]) + " x " + std::to_string(domain.size[1]) + " x " +
            std::to_string(domain.size[2]) + " voxels: at most " + std::to_string(std::lround(bytes / 1e6)) +
            " MB, about " + std::to_string(std::lround(std::ceil(seconds))) + " s");
}

FloatGridPtr make_mountain(app::App& app, const app::Options& o, const app::Domain& domain)
{
    const auto phase = app.phase("mountain");
    return mountain_grid(mountain_heights(domain.box, domain.size, o.spectrum, o.relief), o.relief.half_width);
}

FloatGridPtr make_cloud(app::App& app, const app::Options& o, const app::Domain& domain, const FloatGrid* mask)
{
    CloudBlocks cloud;
    {
        auto phase = app.phase("noise");
        const auto noise = synthesize(domain.size, domain.box.sides(), o.spectrum);
        phase = app.phase("shape");
        cloud = shape_cloud(noise, domain.box, *envelope_of(o, domain, mask), o.shape, app.progress("shape"));
    }
    const auto phase = app.phase("grid");
    auto density = cloud_grid(cloud);
    write_flags(o, *density);
    if (density->empty()) app.warnings()("the density is empty: nothing of the envelope is above the threshold");
    return density;
}

void run(app::App& app, app::Options& o)
{
    o.spectrum.seed = o.cumulus.seed = o.seed;
    o.spectrum.beta = o.beta.value_or(o.mountain ? app::mountain_beta : app::cloud_beta);
    o.spectrum.outer = o.outer.value_or(o.mountain ? app::mountain_outer : app::cloud_outer);
    o.cumulus.up = o.shape.up = o.relief.up = index_of(o.up);
    if (o.mountain && !o.envelope_from.empty())
        throw UsageError("--envelope-from shapes clouds, --mountain makes none");
    if (o.input == "-" && o.envelope_from == "-") throw UsageError("the input and --envelope-from cannot both be -");

    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    if (!o.input.empty()) file = app.read(o.input);
    const auto mask = mask_of(app, o);
    const auto domain = domain_of(o, mask ? bounds_around(*mask, o) : default_bounds(o));
    if (app.dry_run()) return estimate(app, o, domain);

    const auto grid = o.mountain ? make_mountain(app, o, domain) : make_cloud(app, o, domain, mask.get());
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
    return app.run(argc, argv, [&] { run(app, o); });
}
