#include "vdbcloud/scatter/previous_light.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/world_axes.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <optional>

namespace vdbcloud {

namespace {

using openvdb::tools::BoxSampler;

/// Trilinear samples of a grid at places of the world. One object per thread.
template<typename GridT>
class Samples {
public:
    explicit Samples(const GridT& grid) : at_(grid.getConstAccessor()), transform_(grid.transform()) {}
    auto operator()(const Vec3d& place) const { return BoxSampler::sample(at_, transform_.worldToIndex(place)); }
    /// The nearest voxel is active.
    bool active(const Vec3d& place) const
    {
        return at_.isValueOn(openvdb::Coord::round(transform_.worldToIndex(place)));
    }

private:
    typename GridT::ConstAccessor at_;
    const openvdb::math::Transform& transform_;
};

/// Where matter that is at a place now was then. One object per thread.
class Origin {
public:
    explicit Origin(const PreviousLight& of) : seconds_(of.velocity ? of.seconds : 0)
    {
        if (seconds_ != 0) velocity_.emplace(of.velocity->getConstAccessor());
        if (of.velocity) transform_ = of.velocity->transformPtr();
        staggered_ = of.velocity && of.velocity->getGridClass() == openvdb::GRID_STAGGERED;
    }
    Vec3d operator()(const Vec3d& place) const
    {
        if (!velocity_) return place;
        const Vec3d at = transform_->worldToIndex(place);
        const openvdb::Vec3f v = staggered_ ? openvdb::tools::StaggeredBoxSampler::sample(*velocity_, at)
                                            : BoxSampler::sample(*velocity_, at);
        return place - seconds_ * Vec3d(v);
    }

private:
    double seconds_;
    std::optional<Vec3SGrid::ConstAccessor> velocity_;
    openvdb::math::Transform::ConstPtr transform_;
    bool staggered_;
};

/// Calls store(slot, value) for the active slots whose matter came from where `phi` is active, with the value of `grid`
/// there.
template<typename GridT, typename Store>
void carry(const PreviousLight& previous, const Vec3SGrid& phi, const GridT& grid, const VoxelIndex& index,
           const Store& store)
{
    const Blocks& blocks = index.blocks();
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        const Samples<Vec3SGrid> matter(phi);
        const Samples<GridT> at(grid);
        const Origin origin(previous);
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
            if (!blocks.active(slot)) continue;
            const Vec3d place = origin(index.world(Vec3d(blocks.voxel(slot))));
            if (matter.active(place)) store(slot, at(place));
        }
    });
}

}  // namespace

StartingLight starting_light(const PreviousLight& previous, const VoxelIndex& index, int channel, int degree)
{
    const CollidedLight& light = previous.light;
    const Vec3SGridPtr phi = fluence(light);
    StartingLight start;
    start.known.assign(index.blocks().slots(), 0);
    std::vector<std::vector<float>> world(1, std::vector<float>(index.blocks().slots(), 0.0f));
    carry(previous, *phi, *phi, index, [&](size_t slot, const openvdb::Vec3f& value) {
        start.known[slot] = 1;
        world[0][slot] = float(double(value[channel]) / std::sqrt(4 * pi));
    });
    if (const Vec3SGridPtr flux = degree > 0 ? flux_of(light, channel) : nullptr) {
        world.resize(size_t(harmonic_count(1)), std::vector<float>(index.blocks().slots(), 0.0f));
        const int of_axis[3] = {harmonic(1, 1), harmonic(1, -1), harmonic(1, 0)};
        carry(previous, *phi, *flux, index, [&](size_t slot, const openvdb::Vec3f& f) {
            for (int a = 0; a < 3; ++a) world[size_t(of_axis[a])][slot] = float(std::sqrt(3 / (4 * pi)) * double(f[a]));
        });
        for (const FloatGridPtr& moment : light.moments[size_t(channel)]) {
            if (world.size() >= size_t(harmonic_count(degree))) break;
            std::vector<float>& to = world.emplace_back(index.blocks().slots(), 0.0f);
            carry(previous, *phi, *moment, index,
                  [&](size_t slot, float value) { to[slot] = float(light.channel_scale[channel] * double(value)); });
        }
    }
    int whole = 0;  // the last degree of which no moment is missing
    while (size_t(harmonic_count(whole + 1)) <= world.size()) ++whole;
    world.resize(size_t(harmonic_count(whole)));
    start.moments = moments_in_index(index, world, whole);
    start.moments[0] = std::move(world[0]);
    return start;
}

}  // namespace vdbcloud
