#include "vdbcloud/effects/judge.h"

#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/channels.h"
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/optics/joined_medium.h"

#include <algorithm>

namespace vdbcloud {

namespace {

Finding none(const std::string& why) { return {false, false, why}; }
Finding idle(const std::string& why) { return {true, false, why}; }
Finding adds(const std::string& why) { return {true, true, why}; }

std::string count(size_t n, const std::string& what) { return std::to_string(n) + " " + what + (n == 1 ? "" : "s"); }

Finding judge_emission(const EffectFacts& facts)
{
    bool there = false;
    for (const MediumFacts& medium : facts.media) {
        if (emits(medium.emission)) return adds("the medium emits: a grid emission, or a temperature");
        there = there || medium.emission;
    }
    return there ? idle("the grid emission is 0 everywhere")
                 : none("the input has no grid emission and nothing that glows");
}

Finding judge_tint(const EffectFacts& facts)
{
    bool there = false;
    for (const MediumFacts& medium : facts.media) {
        if (tints(medium.tint)) return adds("the grid Cd has values other than 1");
        there = there || medium.tint;
    }
    return there ? idle("the grid Cd is 1 everywhere") : none("the input has no grid Cd");
}

Finding judge_solids(const EffectFacts& facts)
{
    if (facts.solids.empty()) return none("the scene has no solid");
    return adds(count(facts.solids.size(), "solid") + ", the first a " + described(facts.solids.front()));
}

/// Extinction alone decides in a stage of light, and in a picture.
Finding judge_extinctions(const EffectFacts& facts)
{
    for (const MediumFacts& medium : facts.media)
        if (!grey_extinction(medium.medium, tints(medium.tint), medium.delta_f))
            return adds("the channels differ in extinction");
    return none("the channels have one extinction: one computation serves all three");
}

Finding judge_solutions(const EffectFacts& facts)
{
    bool glows = false;
    for (const MediumFacts& medium : facts.media) {
        if (!medium.medium.grey()) return adds("the channels differ in extinction");
        if (!same_channels(medium.medium.albedo)) return adds("the channels differ in albedo");
        if (!same_channels(medium.tint)) return adds("the channels of Cd differ");
        if (!same_channels(medium.emission)) return adds("the channels of emission differ");
        glows = glows || medium.emission;
    }
    const auto coloured = [](const Solid& solid) {
        return !same_channels(solid.material.colour) ||
               (solid.material.checker && !same_channels(*solid.material.checker));
    };
    if (facts.walls && std::any_of(facts.solids.begin(), facts.solids.end(), coloured))
        return adds("the channels of a solid's colour differ");
    std::array<std::vector<double>, 3> strength;
    for (int c = 0; c < 3; ++c) {
        for (const Light& light : facts.lights) strength[size_t(c)].push_back(light.strength()[c]);
        for (const Vec3d& tone : facts.sky.tones()) strength[size_t(c)].push_back(tone[c]);
        strength[size_t(c)].push_back(glows ? 1.0 : 0.0);
    }
    if (multiple(strength[0], strength[1]) && multiple(strength[0], strength[2]))
        return none("the channels coincide: one solution serves all three");
    return adds("the lights and the sky have several colours");
}

Finding judge_anisotropy(const EffectFacts& facts)
{
    for (const MediumFacts& medium : facts.media)
        if (no_scaling(medium.medium.phase, 7).last_degree() > 0) return adds(medium.medium.phase.text());
    return none("the medium scatters alike into all directions");
}

}  // namespace

Finding judge_light(const EffectFacts& facts, size_t light)
{
    if (facts.lights[light].strength() == Vec3d(0.0))
        return facts.lights_shown ? adds("has no power, and a layer") : idle("has no power");
    if (light < facts.hidden.size() && facts.hidden[light]) return idle("reaches no voxel");
    return adds("");
}

bool all_black(const std::vector<Solid>& solids)
{
    return std::all_of(solids.begin(), solids.end(), [](const Solid& solid) { return solid.material.black(); });
}

Finding judge_scattering(const EffectFacts& facts)
{
    const auto any = [&](auto holds) { return std::any_of(facts.media.begin(), facts.media.end(), holds); };
    if (!any([](const MediumFacts& m) { return has_matter(*m.density); })) return none("the density is 0 everywhere");
    if (!any([](const MediumFacts& m) { return m.medium.albedo != Vec3d(0.0); }))
        return none("the albedo is 0: nothing is scattered");
    return adds("");
}

Finding judge(const EffectFacts& facts, Effect effect)
{
    const bool before_scattering = facts.stage == EffectStage::Light;
    switch (effect) {
    case Effect::Emission: return before_scattering ? none("later stages take it") : judge_emission(facts);
    case Effect::Tint: return before_scattering ? none("later stages take it") : judge_tint(facts);
    case Effect::Sky:
        if (before_scattering) return none("later stages take it");
        return facts.sky.dark() ? none("no sky lights the scene") : adds("a sky lights the scene");
    case Effect::Ground:
        if (before_scattering) return none("later stages take it");
        if (!facts.ground_albedo) return none("the scene has no ground");
        return adds("albedo " + shortest(*facts.ground_albedo));
    case Effect::Solids: return judge_solids(facts);
    case Effect::Colour: return facts.stage == EffectStage::Scatter ? judge_solutions(facts) : judge_extinctions(facts);
    case Effect::Anisotropy: return before_scattering ? none("later stages take it") : judge_anisotropy(facts);
    case Effect::Mixture:
        return facts.media.size() > 1 ? adds(std::to_string(facts.media.size()) + " media")
                                      : none("there is one medium");
    case Effect::Periodic:
        return facts.periodic != std::array<bool, 3>{} ? adds("along " + periodic_text(facts.periodic))
                                                       : none("the medium ends on all sides");
    case Effect::Lights:
    case Effect::Multiple: break;
    }
    return none("");
}

}  // namespace vdbcloud
