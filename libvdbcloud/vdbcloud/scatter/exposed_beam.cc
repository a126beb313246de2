#include "vdbcloud/scatter/exposed_beam.h"

#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/voxels/active_box.h"
#include "vdbcloud/voxels/emptiness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double least_thickness = 0.5;  // x below which a voxel is not opaque

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

/// A point of a face [voxels, from the voxel's centre]: the middles of its quarters.
Vec3d point_of_face(int face, int n)
{
    const int axis = face / 2;
    Vec3d point;
    point[axis] = face % 2 ? 0.5 : -0.5;
    point[(axis + 1) % 3] = n & 1 ? 0.25 : -0.25;
    point[(axis + 2) % 3] = n & 2 ? 0.25 : -0.25;
    return point;
}

/// Integrates density over rays through voxels of constant density.
class BoxedRays {
public:
    BoxedRays(const VoxelIndex& index, const std::vector<float>& density)
        : index_(index), density_(density), blocks_(index.blocks()), emptiness_(blocks_), box_(blocks_)
    {
    }

    /// From a point of the face `face` of a voxel to the light [density x world unit].
    double operator()(const Vec3i& voxel, int face, int point, const LightModel& light) const
    {
        const Vec3d from = as_double(voxel) + point_of_face(face, point);
        const Sight sight = light.towards(index_.world(from));
        Vec3d step;  // [voxels / world unit]
        for (int a = 0; a < 3; ++a) {
            const double along = sight.direction.dot(index_.axis(a));
            step[a] = std::abs(along) < 1e-12 ? 0 : along / index_.spacing()[a];
        }
        Vec3i cell = voxel;
        const int axis = face / 2;
        if (step[axis] != 0 && (step[axis] > 0) == (face % 2 == 1)) cell[axis] += face % 2 ? 1 : -1;
        double depth = 0;
        Vec3i block = Emptiness::shifted(cell, 3);
        int32_t found = blocks_.find(block);
        for (double t = 0; t < sight.distance && !beyond(cell, step);) {
            if (const Vec3i now = Emptiness::shifted(cell, 3); now != block) block = now, found = blocks_.find(now);
            const bool exists = size_t(found) < blocks_.count();
            const size_t slot = size_t(found) * Blocks::size + in_block(cell);
            const double to =
                std::min(leave(from, step, cell, exists ? 0 : 3 + emptiness_.bits(block)), sight.distance);
            if (exists) depth += density_[slot] * std::max(to - t, 0.0);  // 0 where a voxel is not active
            if (to == infinity) break;
            t = std::max(t, to);
        }
        return depth;
    }

private:
    bool beyond(const Vec3i& cell, const Vec3d& step) const
    {
        for (int a = 0; a < 3; ++a)
            if ((step[a] >= 0 && cell[a] > box_.last[a]) || (step[a] <= 0 && cell[a] < box_.first[a])) return true;
        return false;
    }
    static size_t in_block(const Vec3i& cell) { return size_t((cell[0] & 7) * 64 + (cell[1] & 7) * 8 + (cell[2] & 7)); }
    /// Where the ray leaves the cube of 2^bits voxels an edge about `cell`, which becomes the voxel beyond.
    static double leave(const Vec3d& from, const Vec3d& step, Vec3i& cell, int bits)
    {
        const int64_t edge = int64_t(1) << bits;
        double t = infinity;
        int out = 0;
        Vec3d low;
        for (int a = 0; a < 3; ++a) {
            low[a] = double(cell[a] & -edge);
            if (step[a] == 0) continue;
            const double at = ((step[a] > 0 ? low[a] + double(edge) : low[a]) - 0.5 - from[a]) / step[a];
            if (at < t) t = at, out = a;
        }
        if (t == infinity) return t;
        for (int a = 0; a < 3; ++a) {
            const double next =
                a == out ? (step[a] > 0 ? low[a] + double(edge) : low[a] - 1)
                         : std::clamp(std::floor(from[a] + t * step[a] + 0.5), low[a], low[a] + double(edge) - 1);
            if (a == out || bits > 0) cell[a] = int(next);
        }
        return t;
    }

    const VoxelIndex& index_;
    const std::vector<float>& density_;
    const Blocks& blocks_;
    const Emptiness emptiness_;
    const ActiveBox box_;
};

}  // namespace

double width_along(const VoxelIndex& index, const Vec3d& direction)
{
    double square = 0;
    for (int a = 0; a < 3; ++a) square += std::pow(direction.dot(index.axis(a)) * index.spacing()[a], 2);
    return std::sqrt(square);
}

void add_boxed_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                      const std::vector<float>& density, double extinction, BeamDepths& depths)
{
    if (index.blocks().period() != Vec3i(0, 0, 0)) return;
    const double most = extinction * index.spacing().length();
    const auto wanted = [&](const ExposedVoxel& voxel) { return most * density[voxel.slot] > least_thickness; };
    if (std::none_of(exposed.begin(), exposed.end(), wanted)) return;
    std::array<std::array<float, BeamDepths::points>, 6> unknown;
    for (auto& of : unknown) of.fill(-1);
    depths.boxed.resize(exposed.size(), unknown);
    const BoxedRays rays(index, density);
    tbb::parallel_for(size_t(0), exposed.size(), [&](size_t k) {
        if (!wanted(exposed[k])) return;
        const Vec3i voxel = index.blocks().voxel(exposed[k].slot);
        for (int face = 0; face < 6; ++face) {
            auto& of = depths.boxed[k][size_t(face)];
            for (int n = 0; n < BeamDepths::points && exposed[k].faces >> face & 1 && of[size_t(n)] < 0; ++n)
                of[size_t(n)] = float(rays(voxel, face, n, *depths.light));
        }
    });
}

void add_boxed_depths(const P1Operator& p1, BeamDepths& depths)
{
    const double extinction = p1.medium().sigma_t_per_density;
    if (p1.uniform()) return add_boxed_depths(p1.index(), p1.exposed(), p1.density(), extinction, depths);
    std::vector<float> scaled = p1.density();
    each_active(p1.blocks(), [&](size_t slot) { scaled[slot] *= float(p1.scaling(slot).extinction); });
    add_boxed_depths(p1.index(), p1.exposed(), scaled, extinction, depths);
}

ExposedBeam::ExposedBeam(const P1Operator& p1, const BeamDepths& depths, double extinction)
    : depths_(depths), extinction_(extinction)
{
    if (depths.boxed.empty()) return;
    const VoxelIndex& index = p1.index();
    weight_.assign(p1.exposed().size(), 0.0f);
    const auto common = depths.light->common_direction();
    const double width = common ? width_along(index, *common) : 0;
    // Of albedo 1, so that the weight does not change with the albedo in which a series expands.
    const auto scaled = [&](size_t slot) { return 1 - p1.delta_f(slot); };
    tbb::parallel_for(size_t(0), weight_.size(), [&](size_t k) {
        const size_t slot = p1.exposed()[k].slot;
        const Vec3d place = index.world(as_double(p1.blocks().voxel(slot)));
        const double along = common ? width : width_along(index, depths.light->towards(place).direction);
        const double x = scaled(slot) * p1.sigma_t(slot) * along / least_thickness;
        if (x > 1) weight_[k] = float(1 - 1 / (x * x));
    });
}

ExposedBeam::Transmitted ExposedBeam::operator()(size_t k, int face) const
{
    Transmitted t{0, 0};
    each_depth(k, face, [&](double weight, double depth) {
        const double tau = extinction_ * depth;
        const double less = tau < 0.5 ? std::expm1(-tau) : std::exp(-tau) - 1;
        t.less += weight * less;
        t.part += weight * (tau < 0.5 ? 1 + less : std::exp(-tau));
    });
    return t;
}

}  // namespace vdbcloud
