#include "vdbcloud/effects/effects.h"

#include "vdbcloud/effects/judge.h"

#include <algorithm>
#include <cstdio>

namespace vdbcloud {

namespace {

using Mode = EffectsAsked::Mode;

EffectState decided(const Finding& finding, const EffectsAsked& asked, Effect effect)
{
    if (!finding.there) return {false, false, finding.why};
    if (!is_asked(asked, effect)) return {false, true, "left out on request"};
    return {finding.adds || asked.mode == Mode::All, false, finding.why};
}

/// Which lights are in play, and the state of all of them.
EffectState decide_lights(const EffectFacts& facts, const EffectsAsked& asked, std::vector<bool>& in_play)
{
    in_play.clear();
    if (facts.lights.empty()) return {false, false, "the scene has no light"};
    const bool wanted = is_asked(asked, Effect::Lights);
    EffectState all{false, !wanted, ""};
    std::string reach, others;
    for (size_t n = 0; n < facts.lights.size(); ++n) {
        const Finding light = judge_light(facts, n);
        in_play.push_back(wanted && (light.adds || asked.mode == Mode::All));
        all.on = all.on || in_play[n];
        const std::string& name = facts.lights[n].name;
        reach += in_play[n] ? (reach.empty() ? "" : ", ") + name : "";
        others += light.why.empty() ? "" : (others.empty() ? "" : ", ") + name + " " + light.why;
    }
    all.why = !wanted ? "left out on request" : reach + (reach.empty() || others.empty() ? "" : "; ") + others;
    return all;
}

}  // namespace

bool is_asked(const EffectsAsked& asked, Effect effect)
{
    return asked.mode != Mode::List || asked.list[size_t(effect)] || !effect_names()[size_t(effect)].optional;
}

Effects::Effects(const EffectFacts& facts, const EffectsAsked& asked) : forced_(asked.mode == Mode::All)
{
    for (const EffectName& name : effect_names())
        states_[size_t(name.effect)] = decided(judge(facts, name.effect), asked, name.effect);
    states_[size_t(Effect::Lights)] = decide_lights(facts, asked, lights_);
    states_[size_t(Effect::Multiple)] = decide_multiple(facts, asked);
}

EffectState Effects::decide_multiple(const EffectFacts& facts, const EffectsAsked& asked)
{
    if (facts.stage == EffectStage::Light) return {false, false, "later stages take it"};
    const Finding scatters = judge_scattering(facts);
    if (!facts.brought && !facts.computed) return {false, false, "the input has none"};
    if (!is_asked(asked, Effect::Multiple)) return {false, true, "left out on request"};
    if (facts.brought) return {true, false, "the input brings it"};
    if (asked.mode == Mode::All) return {true, false, "asked for"};
    if (!facts.needed_by.empty()) return {true, false, facts.needed_by + " needs it"};
    if (on(Effect::Sky)) return {true, false, "it brings the light of the sky"};
    if (on(Effect::Ground)) return {true, false, "it brings the light of the ground"};
    if (!scatters.there) return {false, false, scatters.why};
    if (on(Effect::Emission)) return {true, false, "the medium scatters its emission"};
    if (!on(Effect::Lights)) return {false, false, "no light reaches the medium"};
    if (facts.walls && on(Effect::Solids) && !all_black(facts.solids))
        return {true, false, "it brings the light that solids send back"};
    if (!facts.share) return {true, false, "its share is not estimated for several media"};
    share_ = facts.share();
    const bool matters = share_->share + 2 * share_->error >= facts.accuracy;
    return {matters, !matters,
            "an expected " + share_text(share_->share) + " of scattered light, " + (matters ? "not " : "") + "below " +
                share_text(facts.accuracy)};
}

std::vector<Light> Effects::lights_in_play(const std::vector<Light>& all) const
{
    std::vector<Light> lights;
    for (size_t n = 0; n < all.size(); ++n)
        if (lights_.at(n)) lights.push_back(all[n]);
    return lights;
}

std::string share_text(double share)
{
    const double x = 100 * share;
    if (x > 0 && x < 0.01) return "less than 0.01 %";
    char text[32];
    std::snprintf(text, sizeof text, x > 99.5 ? "%.1f %%" : x >= 5 ? "%.0f %%" : "%.2g %%", std::min(99.9, x));
    return text;
}

}  // namespace vdbcloud
