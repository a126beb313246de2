#include "shared_light.h"

#include "overlap.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/optics/joined_medium.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

bool brings_solution(const GridFile& file) { return fluence_grid(file) || find_grid(file, schema::series_phi_name(0)); }

/// Points of `light_grid` a voxel of `density`, along the axis where there are most.
int points_a_voxel(const GridBase& light_grid, const FloatGrid& density)
{
    double most = 1;
    for (int a = 0; a < 3; ++a) most = std::max(most, density.voxelSize()[a] / light_grid.voxelSize()[a]);
    return int(std::lround(std::min(most, 8.0)));
}

}  // namespace

bool has_several_media(const Scene& scene)
{
    return std::count_if(scene.volumes.begin(), scene.volumes.end(),
                         [](const Volume& volume) { return has_matter(*volume.density); }) > 1;
}

void require_one_solution(const std::vector<GridFile>& files, const Scene& scene)
{
    const auto solved = std::find_if(files.begin(), files.end(), brings_solution);
    if (solved == files.end()) return;
    std::string names;
    size_t count = 0;
    for (size_t v = 0; v < files.size(); ++v) {
        if (overlap_of(files, v).first < v) continue;
        names += " " + files[v].path;
        count += has_matter(*scene.volumes[v].density) || emits(scene.volumes[v].emission.get());
    }
    if (count > 1)
        throw UsageError(solved->path +
                         ": its multiple scattering was computed without the other inputs, which light and shade it: "
                         "expected one file of all, from p1solve" +
                         names + " -o both.vdb");
}

GridBasePtr shared_light_grid(app::App& app, const Scene& scene, size_t v, const Light& light, const GridBasePtr& own,
                              const RenderOptions& o)
{
    const auto phase = app.phase("light");
    std::vector<CrossedMedium> media;
    for (const Volume& volume : scene.volumes) media.push_back({volume.density, volume.medium});
    TransmittanceOptions options = o.light;
    if (own) options.refine = points_a_voxel(*own, *scene.volumes[v].density);
    return transmittance_grid(media, v, light, options, own, app.progress("light"));
}

}  // namespace vdbcloud
