#include "vdbcloud/voxels/voxel_mean.h"

#include "vdbcloud/core/vdb.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr int most_points = 8;  // along an edge

/// Points along an edge of `length` voxels of the grid that is read.
int points_along(double length) { return std::clamp(int(std::ceil(length - 1e-6)), 1, most_points); }

}  // namespace

struct VoxelMean::Reader {
    Reader(const Vec3SGrid& of, const Transform& voxels) : values(of.getConstAccessor())
    {
        if (of.transform() == voxels) return;
        own = of.transformPtr();
        theirs = voxels.copy();
        for (int a = 0; a < 3; ++a) {
            Vec3d unit(0, 0, 0);
            unit[a] = 1;
            points[a] = points_along((place(unit) - place(Vec3d(0.0))).length());
        }
    }

    /// In the index space of the grid that is read, from that of the voxels.
    Vec3d place(const Vec3d& voxel) const { return own->worldToIndex(theirs->indexToWorld(voxel)); }

    Vec3SGrid::ConstAccessor values;
    Transform::ConstPtr own, theirs;  // null where they agree
    int points[3] = {1, 1, 1};
};

VoxelMean::VoxelMean(const Vec3SGrid& of, const Transform& voxels) : reader_(std::make_unique<const Reader>(of, voxels))
{
}

VoxelMean::~VoxelMean() = default;

Vec3f VoxelMean::operator()(const Vec3i& voxel) const
{
    const Reader& r = *reader_;
    if (!r.own) return r.values.getValue(openvdb::Coord(voxel.x(), voxel.y(), voxel.z()));
    const int* n = r.points;
    Vec3d sum(0, 0, 0);
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k) {
                const Vec3d within((i + 0.5) / n[0] - 0.5, (j + 0.5) / n[1] - 0.5, (k + 0.5) / n[2] - 0.5);
                const Vec3d at = r.place(Vec3d(voxel.x(), voxel.y(), voxel.z()) + within);
                sum += Vec3d(openvdb::tools::BoxSampler::sample(r.values, at));
            }
    return Vec3f(sum / double(n[0] * n[1] * n[2]));
}

}  // namespace vdbcloud
