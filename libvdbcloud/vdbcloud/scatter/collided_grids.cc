#include "vdbcloud/scatter/collided_grids.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/spherical_harmonics.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// Flux and moments of one channel that pictures weigh, `scale` times those of a solution.
void add_channel(const VoxelIndex& index, const Solution& solution, double scale, int degree, size_t c,
                 CollidedLight& light)
{
    const auto& [x, y, z] = solution.flux;
    if (light.scaling.mean_cosine() != 0)
        light.flux[c] = index.to_grid({x.data(), y.data(), z.data()}, "", Vec3d(scale));
    const int last = std::min(degree, light.scaling.last_degree());
    for (int k = harmonic_count(1); k < harmonic_count(std::max(last, 1)); ++k) {
        std::vector<float> moment = solution.moments[size_t(k)];
        for (float& value : moment) value = float(scale * value);
        light.moments[c].push_back(index.to_grid(moment.data(), ""));
    }
}

}  // namespace

void collided_grids(const VoxelIndex& index, const std::array<Solution, 3>& solutions,
                    const std::array<Share, 3>& shares, int degree, const std::function<void(GridBase&)>& stamp,
                    CollidedLight& light)
{
    const auto phi = [&](int c) { return solutions[shares[c].of].phi.data(); };
    const Vec3d scale(shares[0].scale, shares[1].scale, shares[2].scale);
    const bool shared = shares[1].of == 0 && shares[2].of == 0;
    if (shared) {
        light.channel_scale = scale;
        light.phi = index.to_grid(phi(0), "");
        add_channel(index, solutions[0], 1, degree, 0, light);
        light.flux[1] = light.flux[2] = light.flux[0];
        light.moments[1] = light.moments[2] = light.moments[0];
    } else {
        light.phi = index.to_grid({phi(0), phi(1), phi(2)}, "", scale);
        for (int c = 0; c < 3; ++c) add_channel(index, solutions[shares[c].of], scale[c], degree, size_t(c), light);
    }
    name_collided_light(light, stamp);
}

}  // namespace vdbcloud
