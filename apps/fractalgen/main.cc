// fractalgen: a fractal cloud as a density grid.
//
//   fractalgen --seed 7 -o cloud.vdb
//   fractalgen --envelope slab --coverage 0.4 --roughness 0.1 --size 256,64,256 --bounds -4,0,-4,4,2,4 -o deck.vdb
//
// Spectral synthesis of 1/f^beta noise (Voss 1985) shapes the surface of an envelope, by default a cumulus of towers.
#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/grid/schema.h"

#include <algorithm>
#include <cmath>

using namespace vdbcloud;

namespace {

/// The envelope within the domain, with room around it for what noise adds.
EnvelopePtr envelope_of(const app::Options& o, const Box& domain)
{
    const Vec3d sides = domain.sides();
    const double longest = std::max({sides[0], sides[1], sides[2]}), shortest = std::min({sides[0], sides[1], sides[2]});
    const double reach = 3 * (o.shape.warp + (o.shape.coverage ? 0 : o.shape.roughness)) * longest;
    Box box = domain.inset(std::min(reach, shortest / 4));
    switch (o.envelope) {
    case app::Region::Sphere: return sphere_envelope(box);
    case app::Region::Ellipsoid: return ellipsoid_envelope(box);
    case app::Region::Box: return box_envelope(box);
    case app::Region::Slab: return slab_envelope(box, o.up);
    case app::Region::Cumulus: break;
    }
    box.low[o.up] = domain.low[o.up];  // a flat base needs no room
    return cumulus_envelope(box, o.cumulus);
}

void write_flags(app::App& app, const app::Options& o, FloatGrid& density)
{
    const bool extinction = app.given("--extinction");
    if (!extinction && !app.given("--albedo") && !app.given("--g")) return;
    write_medium(density, o.medium);
    if (extinction)
        set_text(density, schema::sigma_t_origin, "given");
    else
        density.removeMeta(schema::sigma_t_per_density);
}

/// Bytes at the peak: the noise, and at most as much again for the blocks and the grid made of them.
void estimate(app::App& app, const app::Domain& domain)
{
    const double field = double(fft::RealField<float>::bytes(domain.size));
    const double voxels = double(domain.size[0]) * domain.size[1] * domain.size[2];
    app.report()["estimate"] = {{"memory_bytes", 2 * field}, {"seconds", 3e-8 * voxels}};
    app.say(std::to_string(domain.size[0]) + " x " + std::to_string(domain.size[1]) + " x " +
            std::to_string(domain.size[2]) + " voxels: at most " + std::to_string(std::lround(2 * field / 1e6)) +
            " MB, about " + std::to_string(std::lround(std::ceil(3e-8 * voxels))) + " s");
}

void make_cloud(app::App& app, app::Options& o)
{
    const auto domain = app::domain_of(o);
    if (app.dry_run()) return estimate(app, domain);

    o.spectrum.seed = o.cumulus.seed = o.seed;
    o.cumulus.up = o.shape.up = o.up;
    CloudBlocks cloud;
    {
        auto phase = app.phase("noise");
        const auto noise = synthesize(domain.size, domain.box.sides(), o.spectrum);
        phase = app.phase("shape");
        cloud = shape_cloud(noise, domain.box, *envelope_of(o, domain.box), o.shape, app.progress("shape"));
    }
    auto phase = app.phase("grid");
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    const auto density = cloud_grid(cloud);
    cloud = {};
    phase.reset();
    write_flags(app, o, *density);
    put_grid(file, density);
    set_text(*file.metadata, schema::up_axis, o.up == 1 ? "Y" : "Z");
    app.report()["counts"]["voxels"] = density->activeVoxelCount();
    if (density->empty()) app.warnings()("the density is empty: nothing of the envelope is above the threshold");
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("fractalgen", "A fractal cloud: noise with a power-law spectrum on an envelope, as a density grid.");
    app::Options o;
    app::declare(app, o);
    return app.run(argc, argv, [&] { make_cloud(app, o); });
}
