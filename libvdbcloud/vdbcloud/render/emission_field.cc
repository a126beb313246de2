#include "vdbcloud/render/emission_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// Mean of the eight corners of a cell.
double mean_of_cell(const float* c)
{
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    return 0.125 * (double(c[0]) + c[1] + c[sy] + c[sy + 1] + c[sx] + c[sx + 1] + c[sx + sy] + c[sx + sy + 1]);
}

/// Calls visit(cell within the brick, mean) for each of a brick's cells.
template<typename Visit>
void for_each_cell(const float* corners, const Visit& visit)
{
    for (int i = 0; i < BrickMap::size; ++i)
        for (int j = 0; j < BrickMap::size; ++j)
            for (int k = 0; k < BrickMap::size; ++k)
                if (!visit(Vec3i(i, j, k), mean_of_cell(corners + i * BrickMap::sx + j * BrickMap::sy + k))) return;
}

}  // namespace

EmissionField::EmissionField(const PreparedScene& scene) : scene_(&scene)
{
    Vec3d low(std::numeric_limits<double>::infinity()), high = -low;
    double squares = 0;
    for (size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!scene.volumes[v].emission) continue;
        const BrickMap& map = scene.volumes[v].density;
        const Affine& world = map.world_from_index();
        const double cell = std::abs(
            world.vector(Vec3d(1, 0, 0)).cross(world.vector(Vec3d(0, 1, 0))).dot(world.vector(Vec3d(0, 0, 1))));
        volumes_.push_back(v);
        if (scene.repeats) continue;
        for (const Vec3i& b : map.bricks()) {
            const float* corners = map.find(b);
            double sum = 0;
            Vec3i first(BrickMap::size), end(0);  // of the cells that emit
            for_each_cell(corners, [&](const Vec3i& c, double mean) {
                for (int a = 0; a < 3 && mean > 0; ++a) {
                    first[a] = std::min(first[a], c[a]);
                    end[a] = std::max(end[a], c[a] + 1);
                }
                sum += mean;
                squares += mean * mean * cell;
                return true;
            });
            if (!(sum > 0)) continue;
            for (int n = 0; n < 8; ++n) {
                const Vec3i corner = b * BrickMap::size + Vec3i(n & 1 ? end[0] : first[0], n & 2 ? end[1] : first[1],
                                                                n & 4 ? end[2] : first[2]);
                const Vec3d x = world.point(Vec3d(corner[0], corner[1], corner[2]));
                for (int a = 0; a < 3; ++a) {
                    low[a] = std::min(low[a], x[a]);
                    high[a] = std::max(high[a], x[a]);
                }
            }
            total_ += sum * cell;
            bricks_.push_back({v, b * BrickMap::size, corners, cell});
            cumulative_.push_back(total_);
        }
    }
    // The volume that the same power would fill evenly.
    const Vec3d box = high - low;
    centre_ = 0.5 * (low + high);
    if (total_ > 0 && total_ * total_ / squares > 0.1 * box[0] * box[1] * box[2]) diagonal_ = box.length();
}

bool EmissionField::often_met(const Vec3d& x) const { return (x - centre_).length() < diagonal_; }

EquiangularSampler EmissionField::lit(const WorldRay& ray, double t0, double t1) const
{
    const Vec3d foot = ray.at((centre_ - ray.origin).dot(ray.direction)), aside = centre_ - foot;
    const double distance = aside.length(), least = 0.25 * diagonal_;
    if (distance >= least) return EquiangularSampler(ray, centre_, t0, t1);
    const Vec3d any = std::abs(ray.direction[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    return EquiangularSampler(ray, foot + least * ray.direction.cross(any).unit(), t0, t1);
}

Vec3d EmissionField::point(double u, const Vec3d& in_cell) const
{
    const double sought = u * total_;
    const auto at = std::upper_bound(cumulative_.begin(), cumulative_.end() - 1, sought);
    const size_t n = size_t(at - cumulative_.begin());
    const Brick& brick = bricks_[n];
    const double before = n > 0 ? cumulative_[n - 1] : 0, rest = (sought - before) / brick.cell_volume;
    double sum = 0;
    Vec3i chosen(0);
    for_each_cell(brick.corners, [&](const Vec3i& cell, double mean) {
        if (mean > 0) chosen = cell;
        sum += mean;
        return sum <= rest;
    });
    const Vec3i cell = brick.first + chosen;
    return scene_->volumes[brick.volume].density.world_from_index().point(Vec3d(cell[0], cell[1], cell[2]) + in_cell);
}

double EmissionField::density(const WorldRay& ray) const
{
    // The integral of t^2 over the density of points on the ray.
    constexpr double far = std::numeric_limits<double>::infinity();
    double sum = 0;
    for (size_t n = 0; n < volumes_.size(); ++n) {
        const BrickMap& map = scene_->volumes[volumes_[n]].density;
        march_cells(map, IndexRay(map.index_from_world(), ray), 0, far,
                    [&](double t0, double t1, const float* corners, const Vec3i&) {
                        sum += mean_of_cell(corners) * (t1 * t1 * t1 - t0 * t0 * t0) / 3;
                        return true;
                    });
    }
    return sum / total_;
}

}  // namespace vdbcloud
