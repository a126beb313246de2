#pragma once
// The kinds of light, each defined in a file of its own, and the table of them. Private to scene/.
#include "vdbcloud/scene/light.h"

namespace vdbcloud {

extern const LightKind sun_kind, lamp_kind;

/// All kinds, in the order in which programs list their options.
inline const LightKind* const light_kind_table[] = {&sun_kind, &lamp_kind};

}  // namespace vdbcloud
