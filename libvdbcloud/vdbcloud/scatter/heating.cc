#include "vdbcloud/scatter/heating.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/active_slots.h"

namespace vdbcloud {

namespace {

template<typename GridT, typename F>
GridBasePtr grid_of(const VoxelIndex& index, const F& value)
{
    const auto grid = GridT::create(typename GridT::ValueType(0.0f));
    for (size_t slot = 0; slot < index.blocks().count() * Blocks::size; ++slot) {
        if (!index.blocks().active(slot)) continue;
        const Vec3i p = index.blocks().voxel(slot) + index.origin();
        const openvdb::Coord at(p.x(), p.y(), p.z());
        grid->tree().touchLeaf(at)->setValueOn(at, value(slot));
    }
    return grid;
}

}  // namespace

std::vector<float> heating_rate(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi)
{
    std::vector<float> heating(p1.blocks().slots(), 0.0f);
    each_active(p1.blocks(), [&](size_t slot) {
        const double beam = source.beam_absorbed.empty() ? 0.0 : source.beam_absorbed[slot];
        heating[slot] = float(beam / p1.hbar() + p1.sigma_a(slot) * phi[slot]);
    });
    return heating;
}

GridBasePtr heating_grid(const VoxelIndex& index, const FloatGrid& density,
                         const std::array<const std::vector<float>*, 3>& of, const Vec3d& scale)
{
    const bool grey = of[0] == of[1] && of[0] == of[2] && scale[0] == scale[1] && scale[0] == scale[2];
    const auto value = [&](int c, size_t slot) { return float(scale[c] * (*of[size_t(c)])[slot]); };
    const GridBasePtr grid = grey ? grid_of<FloatGrid>(index, [&](size_t slot) { return value(0, slot); })
                                  : grid_of<Vec3SGrid>(index, [&](size_t slot) {
                                        return Vec3f(value(0, slot), value(1, slot), value(2, slot));
                                    });
    grid->setName(schema::heating);
    grid->setTransform(density.transform().copy());
    return grid;
}

}  // namespace vdbcloud
