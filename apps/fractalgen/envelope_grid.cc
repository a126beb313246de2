#include "envelope_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/mask_envelope.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>

namespace vdbcloud::app {

namespace {

/// How far beyond the envelope noise carries the cloud [fraction of the longest side].
double reach(const Options& o) { return 3 * (o.shape.warp + (o.shape.coverage ? 0 : o.shape.roughness)); }

double longest(const Box& box) { return std::max({box.sides()[0], box.sides()[1], box.sides()[2]}); }

}  // namespace

EnvelopePtr envelope_of(const Options& o, const Domain& domain, const FloatGrid* mask)
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

FloatGridPtr mask_of(App& app, const Options& o, World& world)
{
    if (o.envelope_from.empty()) return nullptr;
    GridFile file = app.read(o.envelope_from);
    world.add(file.path, *file.metadata);
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
    if (auto grid = openvdb::gridPtrCast<FloatGrid>(surface)) return grid;
    throw InputError(o.envelope_from + ": level set '" + surface->getName() + "' is not of floats");
}

Box bounds_around(const FloatGrid& mask, const Options& o)
{
    const Box box = mask_bounds(mask);
    return box.inset(-std::min(reach(o), 0.5) * longest(box));
}

}  // namespace vdbcloud::app
