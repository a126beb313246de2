#pragma once
// What the scene says of each effect, before a request is heard. Private to effects/.
#include "vdbcloud/effects/effects.h"

namespace vdbcloud {

/// What is there of an effect.
struct Finding {
    bool there = false;  ///< the scene has it, and the stage takes it
    bool adds = false;   ///< and it changes the result
    std::string why;
};

/// Whether a light adds to the result, and why not.
Finding judge_light(const EffectFacts&, size_t light);

/// All effects but Lights and Multiple, which need what is in play of the others.
Finding judge(const EffectFacts&, Effect);

/// Whether none of the solids sends light.
bool all_black(const std::vector<Solid>&);

/// Whether the media scatter at all: there is density, and an albedo above 0.
Finding judge_scattering(const EffectFacts&);

}  // namespace vdbcloud
