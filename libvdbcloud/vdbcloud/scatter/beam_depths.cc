#include "vdbcloud/scatter/beam.h"

#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/sweep/light_lattice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3d unit_vector(int axis, double length)
{
    Vec3d v(0, 0, 0);
    v[axis] = length;
    return v;
}

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

/// Where the depth of an exposed face is taken, relative to its centre [voxels]: half a voxel out of the cell along the
/// beam, which travels along `travel` [unit, index space]; at most one voxel.
Vec3d beyond_face(const Vec3d& travel, int axis, int up)
{
    const double along = travel[axis] * (up ? 1 : -1);  // > 0 where the beam leaves
    if (along == 0) return Vec3d(0, 0, 0);
    return travel * std::copysign(std::min(0.5 / std::abs(along), 1.0), along);
}

/// The same from the voxel's centre.
Vec3d beyond_face_centre(const Vec3d& travel, int face)
{
    return unit_vector(face / 2, face % 2 ? 0.5 : -0.5) + beyond_face(travel, face / 2, face % 2);
}

/// Direction of travel of the light at a point, in index space.
Vec3d index_travel(const VoxelIndex& index, const Vec3d& world_travel)
{
    Vec3d d;
    for (int a = 0; a < 3; ++a) d[a] = world_travel.dot(index.axis(a)) / index.spacing()[a];
    return d.unit();
}

/// Sums density x length from a point towards the light through voxels of constant density, wrapping periodic axes.
class PeriodicMarch {
public:
    PeriodicMarch(const VoxelIndex& of, const std::vector<float>& values, const Light& light)
        : index_(of), density_(values)
    {
        const Vec3d h = of.spacing();
        const Affine to_voxels{{of.axis(0) / h[0], of.axis(1) / h[1], of.axis(2) / h[2]}, {}};
        const Vec3i& period = of.blocks().period();
        require_light_that_leaves(light, to_voxels, {period[0] != 0, period[1] != 0, period[2] != 0});
        step_ = to_voxels.vector(*light->common_direction());
        lo_ = Vec3i(std::numeric_limits<int>::max());
        hi_ = Vec3i(std::numeric_limits<int>::min());
        for (size_t b = 0; b < of.blocks().count(); ++b)
            for (int a = 0; a < 3; ++a) {
                lo_[a] = std::min(lo_[a], of.blocks().at(b)[a] * 8);
                hi_[a] = std::max(hi_[a], of.blocks().at(b)[a] * 8 + 7);
            }
        for (int a = 0; a < 3; ++a) {
            if (of.blocks().period()[a] == 0) continue;
            lo_[a] = 0;  // a period may begin or end with empty voxels
            hi_[a] = 8 * of.blocks().period()[a] - 1;
        }
        for (int a = 0; a < 3; ++a)
            if (std::abs(step_[a]) < 1e-12) step_[a] = 0;
    }

    /// Depth from a point (block coordinates) to infinity.
    double operator()(const Vec3d& from) const
    {
        int cell[3];
        double next[3];
        for (int a = 0; a < 3; ++a) {
            const double p = from[a] + 0.5;
            const bool on_face = std::abs(p - std::round(p)) < 1e-9;
            cell[a] = int(on_face ? std::round(p) : std::floor(p));
            if (on_face && step_[a] < 0) --cell[a];
            next[a] = step_[a] > 0 ? (cell[a] + 1 - p) / step_[a] : step_[a] < 0 ? (cell[a] - p) / step_[a] : infinity;
        }
        double t = 0, depth = 0;
        while (inside(cell)) {
            const int a = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
            depth += density_[index_.blocks().slot(Vec3i(cell[0], cell[1], cell[2]))] * (next[a] - t);
            t = next[a];
            cell[a] += step_[a] > 0 ? 1 : -1;
            next[a] += 1 / std::abs(step_[a]);
        }
        return depth;
    }

    const Vec3i& lo() const { return lo_; }
    const Vec3i& hi() const { return hi_; }
    const Vec3d& step() const { return step_; }

private:
    bool inside(const int* cell) const
    {
        for (int a = 0; a < 3; ++a)
            if (index_.blocks().period()[a] == 0 &&
                ((step_[a] >= 0 && cell[a] > hi_[a]) || (step_[a] <= 0 && cell[a] < lo_[a])))
                return false;
        return true;
    }
    const VoxelIndex& index_;
    const std::vector<float>& density_;
    Vec3d step_;
    Vec3i lo_, hi_;
};

}  // namespace

namespace {

/// By the lattice, for all voxels of a block at once.
void depths_by_lattice(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                       const Vec3d& to_light, int rays_per_voxel, std::vector<float>* centres, const Progress& progress,
                       std::atomic<size_t>* products, BeamDepths& depths)
{
    const Blocks& blocks = index.blocks();
    std::vector<Vec3i> all;
    for (size_t b = 0; b < blocks.count(); ++b) all.push_back(blocks.at(b));
    const Vec3d travel = index_travel(index, -to_light);
    std::vector<LatticeTargets> sets;
    for (int a = 0; a < 3; ++a) sets.push_back({unit_vector(a, -0.5), all});
    if (centres) sets.push_back({Vec3d(0.0), all});
    struct Faces {
        int face;
        size_t set;
        std::vector<size_t> place;  // index in the set, by block
    };
    std::vector<Faces> beyond;
    for (int face = 0; face < 6; ++face) {
        if (travel[face / 2] == 0) continue;
        std::vector<Vec3i> wanted;  // blocks with an exposed face of this kind
        std::vector<size_t> place(blocks.count(), blocks.count());
        for (const ExposedVoxel& voxel : exposed)
            if (const size_t b = voxel.slot / 512; voxel.faces >> face & 1 && place[b] == blocks.count()) {
                place[b] = wanted.size();
                wanted.push_back(blocks.at(b));
            }
        beyond.push_back({face, sets.size(), std::move(place)});
        sets.push_back({beyond_face_centre(travel, face), std::move(wanted)});
    }
    auto found = lattice_depths(density, to_light, sets, rays_per_voxel, progress, products);
    const auto take = [&](size_t set) {
        found[set].reserve(blocks.slots());  // resize alone would take twice as much
        found[set].resize(blocks.slots(), 0.0f);
        return std::move(found[set]);
    };
    for (size_t a = 0; a < 3; ++a) depths.lower[a] = take(a);
    if (centres) *centres = take(3);
    for (const Faces& of : beyond)
        for (size_t k = 0; k < exposed.size(); ++k)
            if (exposed[k].faces >> of.face & 1)
                depths.exposed[k][size_t(of.face)] =
                    found[of.set][of.place[exposed[k].slot / 512] * 512 + exposed[k].slot % 512];
}

/// By a ray for each face.
void depths_by_rays(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                    const LightModel& light, BeamDepths& depths)
{
    const Blocks& blocks = index.blocks();
    const auto depth = [&](const Vec3d& voxel) { return float(depth_to_light(density, light, index.world(voxel))); };
    for (int a = 0; a < 3; ++a) {
        depths.lower[a].assign(blocks.slots(), 0.0f);
        each_active(blocks, [&](size_t slot) {
            depths.lower[a][slot] = depth(as_double(blocks.voxel(slot)) + unit_vector(a, -0.5));
        });
    }
    tbb::parallel_for(size_t(0), exposed.size(), [&](size_t k) {
        for (int face = 0; face < 6; ++face) {
            if (!(exposed[k].faces >> face & 1)) continue;
            const Vec3d centre =
                as_double(blocks.voxel(exposed[k].slot)) + unit_vector(face / 2, face % 2 ? 0.5 : -0.5);
            const Sight sight = light.towards(index.world(centre));
            const Vec3d shift = sight.distance > 0
                                    ? beyond_face(index_travel(index, -sight.direction), face / 2, face % 2)
                                    : Vec3d(0.0);
            depths.exposed[k][face] = depth(centre + shift);
        }
    });
}

}  // namespace

namespace {

/// A lamp this near a plane of voxel faces is moved to this distance from the plane [voxels]. On the plane itself the
/// power through a face is both halves of a jump, and rounding would choose the voxel that the lamp shines in.
constexpr double clearance = 1e-3;

/// The light, clear of the planes of voxel faces: the power that it loses errs by `clearance`, to first order.
Light clear_of_faces(const Light& light, const VoxelIndex& index)
{
    const auto source = light->source();
    if (!source) return light;
    Vec3d place = source->position;
    const Vec3d from_origin = source->position - index.world(Vec3d(0, 0, 0));
    bool moved = false;
    for (int a = 0; a < 3; ++a) {
        const double h = index.spacing()[a], p = from_origin.dot(index.axis(a)) / h + 0.5, beyond = p - std::round(p);
        if (std::abs(beyond) >= clearance) continue;
        place += (std::copysign(clearance, beyond) - beyond) * h * index.axis(a);
        moved = true;
    }
    return moved ? Light(light.kind(), light.name, place, light.parameters()) : light;
}

}  // namespace

BeamDepths beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                       const Light& light, int rays_per_voxel, std::vector<float>* centres, const Progress& progress,
                       std::atomic<size_t>* products)
{
    BeamDepths depths(clear_of_faces(light, index));
    depths.exposed.resize(exposed.size());
    if (const auto to_light = light->common_direction())
        depths_by_lattice(index, exposed, density, *to_light, rays_per_voxel, centres, progress, products, depths);
    else
        depths_by_rays(index, exposed, density, *depths.light, depths);
    if (centres && centres->empty()) *centres = centre_depths(index, density, light, rays_per_voxel);
    return depths;
}

std::vector<Vec3d> beam_offsets(const VoxelIndex& index, const Vec3d& to_light, bool centres)
{
    const Vec3d travel = index_travel(index, -to_light);
    std::vector<Vec3d> offsets;
    if (centres) offsets.push_back(Vec3d(0.0));
    for (int a = 0; a < 3; ++a) offsets.push_back(unit_vector(a, -0.5));
    for (int face = 0; face < 6; ++face)
        if (travel[face / 2] != 0) offsets.push_back(beyond_face_centre(travel, face));
    return offsets;
}

BeamDepths periodic_beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                                const std::vector<float>& density, const Light& light)
{
    const PeriodicMarch march(index, density, light);
    BeamDepths depths(light);
    const Blocks& blocks = index.blocks();
    for (int a = 0; a < 3; ++a) {
        depths.lower[a].assign(blocks.slots(), 0.0f);
        each_active(blocks, [&](size_t slot) {
            depths.lower[a][slot] = float(march(as_double(blocks.voxel(slot)) + unit_vector(a, -0.5)));
        });
    }
    depths.exposed.resize(exposed.size());
    tbb::parallel_for(size_t(0), exposed.size(), [&](size_t k) {
        const Vec3d centre = as_double(blocks.voxel(exposed[k].slot));
        for (int face = 0; face < 6; ++face)
            depths.exposed[k][face] = exposed[k].faces >> face & 1
                                          ? float(march(centre + unit_vector(face / 2, face % 2 ? 0.5 : -0.5)))
                                          : 0.0f;
    });
    return depths;
}

double periodic_depth(const VoxelIndex& index, const std::vector<float>& density, const Light& light,
                      const Vec3d& point)
{
    return PeriodicMarch(index, density, light)(point);
}

std::vector<float> centre_depths(const VoxelIndex& index, const BrickMap& density, const Light& light,
                                 int rays_per_voxel)
{
    const Blocks& blocks = index.blocks();
    std::vector<float> centre(blocks.slots(), 0.0f);
    if (const auto to_light = light->common_direction()) {
        std::vector<Vec3i> all;
        for (size_t b = 0; b < blocks.count(); ++b) all.push_back(blocks.at(b));
        centre = lattice_depths(density, *to_light, all, {rays_per_voxel, Vec3d(0.0), 1, nullptr});
        centre.resize(blocks.slots(), 0.0f);
    } else {
        const Light clear = clear_of_faces(light, index);
        each_active(blocks, [&](size_t slot) {
            centre[slot] = float(depth_to_light(density, *clear, index.world(as_double(blocks.voxel(slot)))));
        });
    }
    return centre;
}

std::vector<float> periodic_centre_depths(const VoxelIndex& index, const std::vector<float>& density,
                                          const Light& light)
{
    const PeriodicMarch march(index, density, light);
    std::vector<float> centre(index.blocks().slots(), 0.0f);
    each_active(index.blocks(),
                [&](size_t slot) { centre[slot] = float(march(as_double(index.blocks().voxel(slot)))); });
    return centre;
}

LineDepths periodic_line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light)
{
    const PeriodicMarch march(index, density, light);
    LineDepths lines;
    // Lines start on the side of the box away from the light, across a non-periodic axis, one per voxel of that side.
    int across = 0;
    for (int a = 0; a < 3; ++a)
        if (index.blocks().period()[a] == 0 && march.step()[a] != 0) across = a;
    const int b = (across + 1) % 3, c = (across + 2) % 3;
    const Vec3d h = index.spacing();
    lines.area = h[b] * h[c] * std::abs(light->common_direction()->dot(index.axis(across)));
    Vec3d from;
    from[across] = march.step()[across] > 0 ? march.lo()[across] - 0.5 : march.hi()[across] + 0.5;
    for (int i = march.lo()[b]; i <= march.hi()[b]; ++i)
        for (int j = march.lo()[c]; j <= march.hi()[c]; ++j) {
            from[b] = i + 0.21;  // off the cells' edges
            from[c] = j - 0.17;
            lines.depth.push_back(march(from));
        }
    return lines;
}

double lost_power(const LineDepths& lines, double extinction)
{
    double lost = 0;
    for (double depth : lines.depth) lost -= std::expm1(-extinction * depth);
    return lost * lines.area;
}

}  // namespace vdbcloud
