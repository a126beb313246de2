#include "scatter/fields.h"

#include "vdbcloud/core/vdb.h"

namespace vdbcloud::test {

Vec3SGridPtr constant_like(const FloatGrid& grid, const Vec3f& value)
{
    auto out = Vec3SGrid::create(Vec3f(1.0f));
    out->setTransform(grid.transform().copy());
    for (auto v = grid.cbeginValueOn(); v; ++v) out->tree().setValueOn(v.getCoord(), value);
    return out;
}

}  // namespace vdbcloud::test
