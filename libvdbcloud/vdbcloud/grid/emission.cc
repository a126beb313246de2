#include "vdbcloud/grid/emission.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

namespace vdbcloud {

bool emits(const Vec3SGrid* emission)
{
    bool found = false;
    if (!emission) return false;
    for (auto v = emission->cbeginValueOn(); v && !found; ++v) found = *v != Vec3f(0.0f);
    return found;
}

bool tints(const Vec3SGrid* tint)
{
    bool found = false;
    if (!tint) return false;
    for (auto v = tint->cbeginValueOn(); v && !found; ++v) found = *v != Vec3f(1.0f);
    return found;
}

bool emits_outside(const Vec3SGrid& emission, const FloatGrid& density)
{
    const bool same = emission.transform() == density.transform();
    const auto dark = [&](const openvdb::Coord& voxel) {
        const openvdb::Coord at =
            same ? voxel : density.transform().worldToIndexCellCentered(emission.transform().indexToWorld(voxel));
        return !(density.tree().getValue(at) > 0);
    };
    for (auto v = emission.cbeginValueOn(); v; ++v) {
        const Vec3f& glow = *v;
        if (!(glow[0] > 0 || glow[1] > 0 || glow[2] > 0)) continue;
        openvdb::CoordBBox box;
        v.getBoundingBox(box);
        if (v.isVoxelValue()) {
            if (dark(box.min())) return true;
            continue;
        }
        openvdb::Coord corners[8];
        box.getCornerPoints(corners);
        for (const openvdb::Coord& corner : corners)
            if (dark(corner)) return true;
    }
    return false;
}

bool says_kelvin(const MetaMap& temperature)
{
    const std::string unit = get_text(temperature, schema::unit, "");
    return unit == "K" || unit == "kelvin" || has_meta(temperature, schema::kelvin_scale) ||
           has_meta(temperature, schema::kelvin_offset);
}

}  // namespace vdbcloud
