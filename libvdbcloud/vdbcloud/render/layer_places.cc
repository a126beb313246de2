#include "vdbcloud/render/layer_places.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

void put_colour(double* out, int place, const Vec3d& value)
{
    if (place < 0) return;
    for (int c = 0; c < 3; ++c) out[place + c] = value[c];
}

}  // namespace

LayerPlaces::LayerPlaces(const Film& film, const Scene& scene) : lighting_(scene.sky)
{
    const auto place = [&](const std::string& name) {
        const int layer = film.find(name);
        return layer < 0 ? -1 : film.offset(layer);
    };
    beauty = place("");
    background = place("background");
    sky = place("sky");
    depth = place("Z");
    transmittance = place("transmittance");
    multiple = place("multiscatter");
    emission = place("emission");
    ground = place("ground");
    solid = place("solid");
    for (const auto& light : scene.lights) direct.push_back(place("direct_" + light.name));
}

void LayerPlaces::put(const RayResult& result, const CameraView& view, const Sky& behind, double x, double y,
                      const Vec3d& direction, double* out) const
{
    Vec3d through(std::exp(-result.tau[0]), std::exp(-result.tau[1]), std::exp(-result.tau[2]));
    if (result.to_ground < 1e30) through = Vec3d(0);
    Vec3d sum = result.multiple + result.emission + result.ground + result.solid;
    for (size_t l = 0; l < result.direct.size(); ++l) {
        sum += result.direct[l];
        put_colour(out, direct[l], result.direct[l]);
    }
    put_colour(out, beauty, sum);
    if (beauty >= 0) out[beauty + 3] = 1 - (through[0] + through[1] + through[2]) / 3;
    put_colour(out, background, through * behind.radiance(direction));
    if (sky >= 0) put_colour(out, sky, through * lighting_.radiance(direction));
    const Vec3d& tau = result.true_tau;
    put_colour(out, transmittance, {std::exp(-tau[0]), std::exp(-tau[1]), std::exp(-tau[2])});
    put_colour(out, multiple, result.multiple);
    put_colour(out, emission, result.emission);
    put_colour(out, ground, result.ground);
    put_colour(out, solid, result.solid);
    const double seen = std::min(result.half_way, result.to_ground);
    if (depth >= 0) out[depth] = seen < 1e30 ? view.depth(x, y, seen) : 1e30;
}

}  // namespace vdbcloud
