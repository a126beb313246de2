#include "vdbcloud/sweep/plane_light.h"

#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

namespace {

template<typename T>
void add_all(const std::vector<T>& from, std::vector<T>& to)
{
    for (size_t n = 0; n < to.size(); ++n) to[n] += from[n];
}

}  // namespace

void PlaneLight::add(const PlaneLight& more)
{
    for (size_t face = 0; face < 6; ++face) {
        add_all(more.from_medium[face], from_medium[face]);
        add_all(more.from_sky[face], from_sky[face]);
        add_all(more.medium_along[face], medium_along[face]);
        add_all(more.sky_along[face], sky_along[face]);
        sky_in[face] += more.sky_in[face];
        ground_in[face] += more.ground_in[face];
    }
    traced += more.traced;
    tests += more.tests;
}

void set_half_ranges(const SweepSet& set, PlaneLight& to)
{
    to.sky_in.fill(0);
    to.ground_in.fill(0);
    to.of_unit_radiance.fill(0);
    to.medium_along.fill(std::vector<double>(set.count(), 0.0));
    to.sky_along = to.medium_along;
    to.direction = set.direction;
    to.traced = to.tests = 0;
    for (size_t m = 0; m < set.count(); ++m)
        for (size_t face = 0; face < 6; ++face) {
            const double out = (face % 2 ? 1 : -1) * set.direction[m][int(face / 2)] * set.weight[m];
            if (out > 0) to.of_unit_radiance[face] += out;
            if (out < 0 && !set.inflow.empty()) to.sky_in[face] -= out * set.inflow[m];
        }
}

}  // namespace vdbcloud
