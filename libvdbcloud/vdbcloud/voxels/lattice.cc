#include "vdbcloud/voxels/lattice.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/brick_map.h"

#include <cmath>

namespace vdbcloud {

namespace {

constexpr double tolerance = 1e-4;  // [voxel]; a trilinear value then errs by less than float sums over a cloud do

}  // namespace

Affine index_map(const Transform& from, const Transform& to)
{
    const Affine world = world_from_index(from, "from"), index = index_from_world(to, "to");
    Affine map;
    for (int r = 0; r < 3; ++r)
        map.a[size_t(r)] = index.a[size_t(r)][0] * world.a[0] + index.a[size_t(r)][1] * world.a[1] +
                           index.a[size_t(r)][2] * world.a[2];
    map.b = index.point(world.b);
    return map;
}

std::optional<Vec3d> lattice_shift(const Affine& map, const Vec3d& low, const Vec3d& high)
{
    Vec3d shift = map.point(low) - low;
    for (int corner = 1; corner < 8; ++corner) {
        const Vec3d p(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2]);
        const Vec3d d = map.point(p) - p - shift;
        if (std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) > tolerance) return std::nullopt;
    }
    for (int a = 0; a < 3; ++a)
        if (std::abs(shift[a] - std::round(shift[a])) <= tolerance) shift[a] = std::round(shift[a]);
    return shift;
}

bool is_whole(const Vec3d& s)
{
    return s[0] == std::round(s[0]) && s[1] == std::round(s[1]) && s[2] == std::round(s[2]);
}

}  // namespace vdbcloud
