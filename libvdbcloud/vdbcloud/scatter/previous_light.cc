#include "vdbcloud/scatter/previous_light.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/world_axes.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <cmath>

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

/// Calls f(slot, place) for the active slots whose matter came from the earlier medium, with that place.
template<typename GridT, typename F>
void each_known(const PreviousLight& previous, const GridT& phi, const VoxelIndex& index, const F& f)
{
    const Blocks& blocks = index.blocks();
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        const Samples<GridT> at(phi);
        const Vec3i corner = blocks.origin(b);
        for (size_t n = 0; n < 512; ++n) {
            const size_t slot = b * 512 + n;
            if (!blocks.active(slot)) continue;
            const Vec3d voxel(corner[0] + int(n >> 6), corner[1] + int(n >> 3 & 7), corner[2] + int(n & 7));
            const Vec3d place = previous.origin(index.world(voxel));
            if (at.active(place)) f(slot, place);
        }
    });
}

}  // namespace

Vec3d PreviousLight::origin(const Vec3d& place) const
{
    if (!velocity || seconds == 0) return place;
    return place - seconds * Vec3d(Samples<Vec3SGrid>(*velocity)(place));
}

StartingLight starting_light(const PreviousLight& previous, const VoxelIndex& index, int channel, int degree)
{
    const CollidedLight& light = previous.light;
    const Vec3SGridPtr phi = fluence(light);
    StartingLight start;
    start.known.assign(index.blocks().slots(), 0);
    std::vector<std::vector<float>> world(1, std::vector<float>(index.blocks().slots(), 0.0f));
    each_known(previous, *phi, index, [&](size_t slot, const Vec3d& place) {
        start.known[slot] = 1;
        world[0][slot] = float(double(Samples<Vec3SGrid>(*phi)(place)[channel]) / std::sqrt(4 * pi));
    });
    if (const Vec3SGridPtr flux = degree > 0 ? flux_of(light, channel) : nullptr) {
        world.resize(size_t(harmonic_count(1)), std::vector<float>(index.blocks().slots(), 0.0f));
        const int of_axis[3] = {harmonic(1, 1), harmonic(1, -1), harmonic(1, 0)};
        each_known(previous, *phi, index, [&](size_t slot, const Vec3d& place) {
            const auto f = Samples<Vec3SGrid>(*flux)(place);
            for (int a = 0; a < 3; ++a) world[size_t(of_axis[a])][slot] = float(std::sqrt(3 / (4 * pi)) * double(f[a]));
        });
        for (const FloatGridPtr& moment : light.moments[size_t(channel)]) {
            if (world.size() >= size_t(harmonic_count(degree))) break;
            std::vector<float>& to = world.emplace_back(index.blocks().slots(), 0.0f);
            each_known(previous, *phi, index, [&](size_t slot, const Vec3d& place) {
                to[slot] = float(light.channel_scale[channel] * double(Samples<FloatGrid>(*moment)(place)));
            });
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
