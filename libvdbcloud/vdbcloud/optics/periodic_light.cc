#include "vdbcloud/optics/periodic_light.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud {

void require_light_that_leaves(const Light& light, const Affine& index_from_world, const std::array<bool, 3>& periodic)
{
    if (!periodic[0] && !periodic[1] && !periodic[2]) return;
    const auto to_light = light->common_direction();
    if (!to_light) throw InputError("light '" + light.name + "': in a periodic medium expected a light at infinity");
    const Vec3d step = index_from_world.vector(*to_light);
    for (int a = 0; a < 3; ++a)
        if (!periodic[size_t(a)] && std::abs(step[a]) > 1e-9 * step.length()) return;
    throw InputError("light '" + light.name +
                     "': in a periodic medium expected a light that is not parallel to every axis that ends");
}

}  // namespace vdbcloud
