#pragma once
// Copies of a grid elsewhere in the world.
#include "vdbcloud/core/vdb.h"

namespace vdbcloud::test {

/// A copy whose voxels are scaled along their axes, then turned about the world's z axis, then shifted.
inline FloatGridPtr moved(const FloatGridPtr& grid, const Vec3d& by, double angle = 0, const Vec3d& scale = Vec3d(1))
{
    auto out = grid->deepCopy();
    const auto transform = grid->transform().copy();
    transform->preScale(scale);
    transform->postRotate(angle, openvdb::math::Z_AXIS);
    transform->postTranslate(by);
    out->setTransform(transform);
    return out;
}

}  // namespace vdbcloud::test
