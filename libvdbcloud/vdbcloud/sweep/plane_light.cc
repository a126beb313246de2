#include "vdbcloud/sweep/plane_light.h"

#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

void set_half_ranges(const SweepSet& set, PlaneLight& to)
{
    to.sky_in.fill(0);
    to.ground_in.fill(0);
    to.of_unit_radiance.fill(0);
    for (size_t m = 0; m < set.count(); ++m)
        for (size_t face = 0; face < 6; ++face) {
            const double out = (face % 2 ? 1 : -1) * set.direction[m][int(face / 2)] * set.weight[m];
            if (out > 0) to.of_unit_radiance[face] += out;
            if (out < 0 && !set.inflow.empty()) to.sky_in[face] -= out * set.inflow[m];
        }
}

}  // namespace vdbcloud
