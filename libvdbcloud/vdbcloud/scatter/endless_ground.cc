#include "vdbcloud/scatter/endless_ground.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/ground.h"
#include "vdbcloud/scene/ground.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vdbcloud {

namespace {

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

}  // namespace

EndlessGround::EndlessGround(const VoxelIndex& index, const Vec3d& up, double albedo, const std::vector<Light>& lights,
                             const Sky& sky)
    : index_(index), lights_(lights), albedo_(albedo), up_(up.unit())
{
    check_ground_albedo(albedo);
    patch_.face = face_down(index, up);
    for (const Light& light : lights) {
        if (!light->common_direction())
            throw InputError("light '" + light.name +
                             "' over an endless ground beneath a medium that ends on all sides: expected a sun. For "
                             "lamps: render --integrator path");
        require_light_above(light, Ground{albedo, Vec3d(0), up_});
        const Vec3d place = index.world(Vec3d(0));
        radiance_ += light.strength() * light->irradiance(place) * light->towards(place).direction.dot(up_);
    }
    radiance_ = albedo_ * (radiance_ / pi + (sky.dark() ? Vec3d(0) : sky.mean_inflow(up_)));
    set_patch(up_);
}

void EndlessGround::set_patch(const Vec3d& up)
{
    const ActiveBox box(index_.blocks());
    const int axis = patch_.face / 2, side = patch_.face % 2 ? 1 : -1;
    const auto along = ActiveBox::axes(axis);
    patch_.plane = (side > 0 ? box.last : box.first)[axis] + side;
    const double height = (box.size(axis) + 1) * index_.spacing()[axis];
    std::array<double, 2> low, high;
    for (size_t k = 0; k < 2; ++k) {
        const double h = index_.spacing()[along[k]];
        low[k] = box.first[along[k]] - margin * height / h;
        high[k] = box.last[along[k]] + margin * height / h;
        for (const Light& light : lights_) {
            const Vec3d way = light->towards(Vec3d(0)).direction;
            const double run = -way.dot(index_.axis(along[k])) / way.dot(up);  // of the shadow, by height
            const double shadow = std::clamp(run, -longest_shadow, longest_shadow) * height / h;
            low[k] = std::min(low[k], box.first[along[k]] - 1 + shadow);
            high[k] = std::max(high[k], box.last[along[k]] + 1 + shadow);
        }
    }
    for (size_t k = 0; k < 2; ++k) {             // cells have integers
        constexpr double farthest = 2147483520;  // 2^31 less some cells
        low[k] = std::max(low[k], -farthest / 2);
        high[k] = std::min(high[k], farthest / 2);
    }
    const size_t most = std::max(least_cells, index_.blocks().active_count());
    for (patch_.edge = 1;; patch_.edge *= 2) {
        for (size_t k = 0; k < 2; ++k) {
            patch_.first[k] = int(std::floor(low[k]));
            patch_.count[k] = int(std::ceil((high[k] - patch_.first[k]) / patch_.edge)) + 1;
        }
        if (patch_.cells() <= most) return;
    }
}

void EndlessGround::add_on_faces(int c, std::array<double, 6>& radiance) const
{
    for (int face = 0; face < 6; ++face)
        radiance[size_t(face)] += radiance_[c] * (1 - index_.axis(face / 2).dot(up_) * (face % 2 ? 1 : -1)) / 2;
}

void EndlessGround::add_along(int c, const std::vector<Vec3d>& travel, std::vector<float>& radiance) const
{
    const int axis = patch_.face / 2, rising = patch_.face % 2 ? -1 : 1;
    for (size_t m = 0; m < travel.size(); ++m)
        if (travel[m][axis] * rising > 0) radiance[m] += float(radiance_[c]);
}

SweepGround EndlessGround::swept(const BeamMedium& medium, int c) const
{
    SweepGround ground{patch_.face, albedo_, std::vector<float>(patch_.cells(), 0.0f), patch_, {}};
    const int parts = this->parts();
    const auto [u, v] = ActiveBox::axes(patch_.face / 2);
    tbb::parallel_for(size_t(0), patch_.cells(), [&, u = u, v = v](size_t cell) {
        double sum = 0;
        for (int n = 0; n < parts * parts; ++n) {
            Vec3d at = as_double(patch_.middle(cell));
            at[u] += ((n / parts + 0.5) / parts - 0.5) * patch_.edge;
            at[v] += ((n % parts + 0.5) / parts - 0.5) * patch_.edge;
            for (const Light& light : lights_) {
                const Vec3d place = index_.world(at);
                const double lost = -std::expm1(-medium.extinction() * medium.depth(at, light));
                sum -= light.strength()[c] * light->irradiance(place) * light->towards(place).direction.dot(up_) * lost;
            }
        }
        ground.direct[cell] = float(sum / (parts * parts));
    });
    return ground;
}

std::vector<float> EndlessGround::radiance_change(const std::vector<float>& direct,
                                                  const std::vector<float>& diffuse) const
{
    std::vector<float> cells(direct.size());
    for (size_t n = 0; n < cells.size(); ++n) cells[n] = float(albedo_ / pi * (double(direct[n]) + diffuse[n]));
    return cells;
}

void EndlessGround::add_to(const P1Operator& p1, const std::vector<float>& change, const Ordinates& set,
                           P1Source& source) const
{
    const std::vector<Vec3d>& travel = set.direction;
    const int axis = patch_.face / 2, rising = patch_.face % 2 ? -1 : 1;
    const auto [u, v] = ActiveBox::axes(axis);
    tbb::parallel_for(size_t(0), p1.exposed().size(), [&, u = u, v = v](size_t k) {
        const ExposedVoxel& voxel = p1.exposed()[k];
        for (int face = 0; face < 6; ++face) {
            if (!(voxel.faces >> face & 1)) continue;
            const int across = face / 2, outward = face % 2 ? 1 : -1;
            Vec3d middle = as_double(index_.blocks().voxel(voxel.slot));
            middle[across] += 0.5 * outward;
            double inflow = 0, unit = 0;  // over all directions that come in: pi, but for the quadrature
            for (size_t m = 0; m < travel.size(); ++m) {
                const double in = -outward * travel[m][across] * set.weight[m];
                if (!(in > 0)) continue;
                unit += in;
                if (!(travel[m][axis] * rising > 0)) continue;
                const double rise = (middle[axis] - patch_.plane) * index_.spacing()[axis] / travel[m][axis];
                inflow += in * patch_.interpolate(change, {middle[u] - rise * travel[m][u] / index_.spacing()[u],
                                                           middle[v] - rise * travel[m][v] / index_.spacing()[v]});
            }
            const double j = unit > 0 ? inflow * pi / unit : 0;
            const double leaving =
                p1.boundary_flux(voxel, face, 0, -2 * p1.face_weight(voxel, face) * j) * p1.face_area(across);
            source.rhs[voxel.slot] -= leaving;
            source.outflow[k][size_t(face)] += leaving;
        }
    });
}

double EndlessGround::power(const std::vector<float>& cells) const
{
    const auto [u, v] = ActiveBox::axes(patch_.face / 2);
    return std::accumulate(cells.begin(), cells.end(), 0.0) * index_.spacing()[u] * index_.spacing()[v] * patch_.edge *
           patch_.edge;
}

Vec3SGridPtr EndlessGround::grid(const std::array<const std::vector<float>*, 3>& change, const Vec3d& scale,
                                 const Transform& transform) const
{
    auto grid = Vec3SGrid::create(Vec3f(radiance_));
    grid->setName(schema::ground_radiance);
    auto of = transform.copy();
    const auto [u, v] = ActiveBox::axes(patch_.face / 2);
    Vec3d edge(1);
    edge[u] = edge[v] = patch_.edge;
    Vec3i first = patch_.middle(0) + index_.origin();
    if (patch_.edge > 1) {
        of->preTranslate(as_double(first));
        of->preScale(edge);
        first = Vec3i(0);
    }
    grid->setTransform(of);
    auto accessor = grid->getAccessor();
    for (size_t cell = 0; cell < patch_.cells(); ++cell) {
        Vec3i at = first;
        at[u] += int(cell) / patch_.count[1];
        at[v] += int(cell) % patch_.count[1];
        const Vec3d by_medium((*change[0])[cell], (*change[1])[cell], (*change[2])[cell]);
        accessor.setValueOn(openvdb::Coord(at[0], at[1], at[2]), Vec3f(radiance_ + by_medium * scale));
    }
    return grid;
}

}  // namespace vdbcloud
