#include "vdbcloud/render/path_end.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

namespace vdbcloud {

namespace {

const Scene& with_multiple_scattering(const Scene& scene)
{
    for (const Volume& volume : scene.volumes)
        if (!volume.collided.phi && !volume.density->empty() && volume.medium.sigma_t_per_density != Vec3d(0.0))
            throw InputError("grid '" + printable(volume.density->getName()) +
                             "': no multiple scattering in which light paths could end: run p1solve first");
    return scene;
}

}  // namespace

PathEndScene::PathEndScene(const Scene& scene)
    : media(with_multiple_scattering(scene), IntegratorOptions()), ground(scene)
{
}

PathEnd::PathEnd(const PathEndScene& scene)
    : scene_(scene), march_(make_cells_integrator(scene.media, IntegratorOptions()))
{
}

const RayResult& PathEnd::along(const WorldRay& ray)
{
    (*march_)(ray, result_);
    scene_.ground.add(ray, result_);
    return result_;
}

}  // namespace vdbcloud
