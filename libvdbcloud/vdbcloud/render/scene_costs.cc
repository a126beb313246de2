#include "vdbcloud/render/scene_costs.h"

#include "vdbcloud/core/vdb.h"

#include <set>

namespace vdbcloud {

namespace {

/// Adds maps once each, for volumes share some.
class Maps {
public:
    Maps(EffectCosts& costs, uint64_t cells) : costs_(costs), cells_(cells) {}

    void add(Effect effect, const BrickMap* map)
    {
        if (map && known_.insert(map).second) add(effect, 1, double(map->bytes()));
    }
    void add(Effect effect, uint64_t fields, double bytes)
    {
        if (fields == 0) return;
        costs_.hold(effect, fields, bytes);
        costs_.enter(effect, double(cells_) * double(fields));
    }

private:
    EffectCosts& costs_;
    uint64_t cells_;
    std::set<const BrickMap*> known_;
};

/// The values of a plain scene, which lie together.
void add_plain(const PreparedVolume& volume, size_t lights, Maps& maps)
{
    const double each = volume.fields->bytes_of_value();
    const uint64_t phi = uint64_t(volume.field_channels), rest = uint64_t(volume.fields->count()) - lights - phi;
    maps.add(Effect::Lights, lights, each * double(lights));
    maps.add(Effect::Multiple, phi, each * double(phi));
    maps.add(Effect::Anisotropy, rest, each * double(rest));
}

}  // namespace

EffectCosts costs_of(const Scene& scene, const PreparedScene& prepared, uint64_t rays, uint64_t cells)
{
    EffectCosts costs;
    Maps maps(costs, cells);
    for (const PreparedVolume& volume : prepared.volumes) {
        if (volume.fields) add_plain(volume, scene.lights.size(), maps);
        maps.add(Effect::Tint, volume.colour.get());
        maps.add(Effect::Emission, volume.emission.get());
        if (volume.emission) maps.add(Effect::Emission, &volume.density);
        for (const auto& depth : volume.light_depth) maps.add(Effect::Lights, depth.get());
        for (const auto& seen : volume.seen) maps.add(Effect::Solids, seen.get());
        maps.add(Effect::Multiple, volume.phi.get());
        for (size_t c = 0; c < 3; ++c) {
            maps.add(Effect::Anisotropy, volume.flux[c].get());
            for (const auto& moment : volume.moments[c]) maps.add(Effect::Anisotropy, moment.get());
        }
    }
    // Light paths and shadow rays read no grids of light.
    if (costs[Effect::Lights].fields == 0) costs.enter(Effect::Lights, double(cells) * double(scene.lights.size()));
    if (prepared.solids) {
        costs.enter(Effect::Solids, double(rays) * double(prepared.solids->count()));
        costs.hold(Effect::Solids, prepared.solids->count(), bytes_of(scene.solids));
    }
    if (scene.ground) {
        costs.enter(Effect::Ground, double(rays));
        if (scene.ground_radiance) costs.hold(Effect::Ground, 1, double(scene.ground_radiance->memUsage()));
    }
    if (!scene.sky.dark()) costs.enter(Effect::Sky, double(rays));
    if (prepared.repeats) costs.enter(Effect::Periodic, double(rays));
    if (scene.volumes.size() > 1) costs.enter(Effect::Mixture, double(cells) * double(scene.volumes.size() - 1));
    if (!prepared.grey) costs.enter(Effect::Colour, 2 * double(cells));
    return costs;
}

}  // namespace vdbcloud
