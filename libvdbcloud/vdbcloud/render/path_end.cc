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

IntegratorOptions one_solid_ray()
{
    IntegratorOptions options;
    options.solid_rays = 1;
    return options;
}

}  // namespace

PathEndScene::PathEndScene(const Scene& scene)
    : options(one_solid_ray()), media(with_multiple_scattering(scene), options), surfaces(scene, media, options)
{
}

PathEnd::PathEnd(const PathEndScene& scene) : march_(scene.surfaces) {}

const RayResult& PathEnd::along(const WorldRay& ray, PathRandom random)
{
    march_(ray, random, result_);
    return result_;
}

}  // namespace vdbcloud
