#include "vdbcloud/scatter/planes.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/scatter/sky_inflow.h"

#include <algorithm>

namespace vdbcloud {

namespace {

double sum(const std::array<double, 6>& of) { return std::accumulate(of.begin(), of.end(), 0.0); }

double cell_area(const VoxelIndex& index, int face)
{
    const auto [u, v] = ActiveBox::axes(face / 2);
    return index.spacing()[u] * index.spacing()[v];
}

/// Factor from the sums of a quadrature to power per area.
double to_power(const PlaneLight& light, int face)
{
    const double unit = light.of_unit_radiance[size_t(face)];
    return unit > 0 ? pi / unit : 0;
}

/// The share of the sky's light through an empty box that goes into a hemisphere.
double sky_share(const VoxelIndex& index, const ActiveBox& box, const Sky& sky, int channel,
                 const Hemisphere& hemisphere)
{
    if (sky.dark()) return 0;
    const Ordinates set = ordinates(OrdinateKind::Product, 2048, 1);
    const std::vector<float> radiance = sky_along(index, sky, channel, set.direction);
    double all = 0, within = 0;
    for (size_t m = 0; m < set.count(); ++m) {
        double area = 0;  // of the box, as light along this direction sees it
        for (int face = 0; face < 6; ++face)
            area += std::max(0.0, (face % 2 ? 1 : -1) * set.direction[m][face / 2]) * double(box.cells(face)) *
                    cell_area(index, face);
        all += set.weight[m] * radiance[m] * area;
        within += set.weight[m] * radiance[m] * area * hemisphere.of_direction(set.direction[m]);
    }
    return all > 0 ? within / all : 0;
}

}  // namespace

Hemisphere reflected_into(const VoxelIndex& index, const std::optional<Vec3d>& to_sun, const Vec3d& up)
{
    for (const Vec3d& towards : {to_sun.value_or(up), up, Vec3d(1, 1, 1)}) {
        Vec3d axis;
        for (int a = 0; a < 3; ++a) axis[a] = index.blocks().period()[a] ? 0 : towards.dot(index.axis(a));
        if (axis.length() > 1e-9 * towards.length()) return Hemisphere(axis);
    }
    return Hemisphere(Vec3d(0, 1, 0));
}

PlanePower planes_by_rays(const P1Operator& p1, const P1Source& source, const P1Budget& budget, const OutflowRays& rays,
                          const Sky& sky, int channel, const Hemisphere& hemisphere, const PlaneGround& ground)
{
    PlanePower power;
    power.known = true;
    const VoxelIndex& index = p1.index();
    const ActiveBox box(index.blocks());
    const double outflow = sum(budget.out) - budget.to_ground;
    power.reentered = outflow * rays.reentry;
    std::array<double, 6> into{};  // the sky's power on exposed faces
    for (const ExposedVoxel& voxel : p1.exposed())
        for (size_t face = 0; face < 6; ++face)
            if (const int a = int(face / 2); voxel.faces >> face & 1)
                into[face] += voxel.weight[a] * p1.face_area(a) * source.sky_inflow[face] / 4 * p1.hbar() * p1.hbar();
    const std::array<double, 6> radiance = sky_on_faces(index, sky, channel);
    for (int face = 0; face < 6; ++face)
        power.sky_in[size_t(face)] = pi * radiance[size_t(face)] * double(box.cells(face)) * cell_area(index, face);
    for (size_t face = 0; face < 6; ++face) {
        const size_t opposite = face ^ 1;  // light that comes in there straight goes on to leave here
        const double blocked = into[opposite] + budget.sky_in * rays.sky_moved[face];
        power.out[face] = budget.out[face] + outflow * rays.moved[face] + power.sky_in[opposite] - blocked;
        power.reflected += hemisphere.of_face(int(face)) * (budget.out[face] - into[opposite]);
    }
    power.reflected += outflow * rays.moved_ahead - budget.sky_in * rays.sky_moved_ahead +
                       sum(power.sky_in) * sky_share(index, box, sky, channel, hemisphere);
    if (ground.face >= 0) {
        power.from_ground = ground.up(0);
        power.out[size_t(ground.face)] += power.from_ground;
        power.reflected += hemisphere.of_face(ground.face) * power.from_ground;
    }
    return power;
}

PlanePower planes_by_sweep(const VoxelIndex& index, const PlaneLight& light, const P1Budget& budget, double reentry,
                           const Hemisphere& hemisphere, const PlaneGround& ground, bool scaled)
{
    PlanePower power;
    power.known = true;
    power.reentered = reentry * (sum(budget.out) - budget.to_ground);
    std::array<double, 6> medium{}, sky{};
    const ActiveBox box(index.blocks());
    double from_patch = 0, ahead = 0, sky_ahead = 0;
    for (int face = 0; face < 6; ++face) {
        const double area = to_power(light, face) * cell_area(index, face);
        const auto total = [&](const std::vector<double>& along, bool into_hemisphere) {
            double all = 0;
            for (size_t m = 0; m < along.size(); ++m)
                all += area * along[m] * (into_hemisphere ? hemisphere.of_direction(light.direction[m]) : 1);
            return all;
        };
        const auto &from_medium = light.medium_along[size_t(face)], &from_sky = light.sky_along[size_t(face)];
        medium[size_t(face)] = total(from_medium, false);
        sky[size_t(face)] = total(from_sky, false);
        ahead += total(from_medium, true);
        sky_ahead += total(from_sky, true);
        power.sky_in[size_t(face)] =
            light.sky_in[size_t(face)] * to_power(light, face ^ 1) * double(box.cells(face)) * cell_area(index, face);
        from_patch += light.ground_in[size_t(face)] * to_power(light, face ^ 1) * cell_area(index, face);
    }
    double from_medium = sum(budget.out) - budget.sky_in + sum(power.sky_in) + from_patch - power.reentered - sum(sky);
    double scalable = sum(medium);
    if (ground.face >= 0) {
        // What the ground sends up grows with what is scaled, where the plane gives its light.
        const size_t face = size_t(ground.face);
        from_medium += ground.up(sky[face]);
        if (ground.diffuse < 0) scalable -= ground.albedo * medium[face];
    }
    if (scaled && scalable != 0) power.scaled_by = from_medium / scalable - 1;
    for (size_t face = 0; face < 6; ++face) power.out[face] = medium[face] * (1 + power.scaled_by) + sky[face];
    power.reflected = ahead * (1 + power.scaled_by) + sky_ahead;
    power.from_ground = ground.face >= 0 ? ground.up(power.out[size_t(ground.face)]) : from_patch;
    return power;
}

std::vector<float> plane_flux(const PlaneLight& light, const PlanePower& power, int face)
{
    const auto &medium = light.from_medium[size_t(face)], &sky = light.from_sky[size_t(face)];
    std::vector<float> flux(medium.size());
    for (size_t n = 0; n < flux.size(); ++n)
        flux[n] = float(to_power(light, face) * (medium[n] * (1 + power.scaled_by) + sky[n]));
    return flux;
}

}  // namespace vdbcloud
