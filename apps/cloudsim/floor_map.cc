// Maps of the floor's fluxes from images and grids.
#include "options.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/render/image_in.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

std::vector<double> from_grid(App& app, const std::string& path, const sim::Lattice& l, UpAxis up_axis)
{
    GridFile file = app.read(path);
    const auto grid = density_of(file, {}, app.warnings());
    const auto box = grid->evalActiveVoxelBoundingBox();
    const int up = index_of(read_up_axis(*file.metadata).value_or(up_axis)), across = 3 - up;
    const double metres = get_number(*file.metadata, schema::meters_per_unit, 1);
    std::vector<double> map;
    auto accessor = grid->getConstAccessor();
    for (int j = 0; j < l.n[1]; ++j)
        for (int i = 0; i < l.n[0]; ++i) {
            Vec3d world(0, 0, 0);
            world[0] = (i + 0.5 - 0.5 * l.n[0]) * l.h[0], world[across] = (j + 0.5 - 0.5 * l.n[1]) * l.h[1];
            auto at = openvdb::Coord::round(grid->transform().worldToIndex(world / metres));
            at[up] = box.min()[up];
            map.push_back(double(accessor.getValue(at)));
        }
    return map;
}

std::vector<double> from_image(const std::string& path, const sim::Lattice& l)
{
    const Pixels image = read_pixels(path);
    const int colours = std::min(image.channels, 3);
    std::vector<double> map;
    for (int j = 0; j < l.n[1]; ++j)
        for (int i = 0; i < l.n[0]; ++i) {
            const int x = std::min(image.width - 1, int((i + 0.5) / l.n[0] * image.width));
            const int y = std::min(image.height - 1, int((1 - (j + 0.5) / l.n[1]) * image.height));
            double sum = 0;
            for (int c = 0; c < colours; ++c)
                sum += double(
                    image.values[(size_t(y) * size_t(image.width) + size_t(x)) * size_t(image.channels) + size_t(c)]);
            map.push_back(sum / colours);
        }
    return map;
}

}  // namespace

std::vector<double> read_floor_map(App& app, const std::string& path, const sim::Lattice& l, UpAxis up_axis)
{
    const bool grid = path == "-" || (path.size() > 4 && path.substr(path.size() - 4) == ".vdb");
    return grid ? from_grid(app, path, l, up_axis) : from_image(path, l);
}

}  // namespace vdbcloud::app
