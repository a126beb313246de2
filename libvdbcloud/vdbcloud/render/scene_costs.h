#pragma once
// What the effects of a scene cost a picture. Private to render/.
#include "vdbcloud/core/effects.h"
#include "vdbcloud/render/media.h"

namespace vdbcloud {

/// Fields and bytes are those of the maps that rays read. Entries: of fields, the values that rays read for the effect,
/// one for each field and each of `cells`; of solids, the tests of `rays`. Rays serve all effects together, so no time
/// is that of one.
EffectCosts costs_of(const Scene&, const PreparedScene&, uint64_t rays, uint64_t cells);

}  // namespace vdbcloud
