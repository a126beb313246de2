#include "vdbcloud/render/ground_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <cmath>

namespace vdbcloud {

GroundLight::GroundLight(const Scene& scene) : ground_(scene.ground)
{
    if (!ground_) return;
    for (const Light& light : scene.lights) require_light_above(light, *ground_);
    if (!scene.ground_radiance || scene.volumes.empty())
        throw InputError("a ground without the light on it: expected Scene::ground_radiance, which p1solve makes");
    const FloatGrid& density = *scene.volumes.front().density;
    const Period period = period_in(period_of(density, scene.periodic), density.transform(), *scene.ground_radiance);
    const Vec3f far = scene.ground_radiance->background();
    far_ = Vec3d(far);
    if (far == Vec3f(0.0f)) {
        change_.emplace(*scene.ground_radiance, 0.0f, BrickMap::Map(), period);
        return;
    }
    const auto change = scene.ground_radiance->deepCopy();
    for (auto v = change->beginValueOn(); v; ++v) v.setValue(*v - far);
    change_.emplace(*change, 0.0f, BrickMap::Map(), period);
}

void GroundLight::add(const WorldRay& ray, RayResult& result) const
{
    if (!ground_) return;
    if (ground_->height(ray.origin) < 0) {
        const size_t lights = result.direct.size();
        result.clear(lights);
        result.to_ground = 0;
        return;
    }
    const double t = ground_->distance(ray);
    if (!std::isfinite(t)) return;
    result.to_ground = t;
    const Vec3d through(std::exp(-result.tau[0]), std::exp(-result.tau[1]), std::exp(-result.tau[2]));
    result.ground = through * (far_ + change_->sample3(change_->index_from_world().point(ray.at(t))));
}

}  // namespace vdbcloud
