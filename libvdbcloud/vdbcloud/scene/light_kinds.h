#pragma once
// The kinds of light, each defined in a file of its own. light.cc has the table of them. Private to scene/.
#include "vdbcloud/scene/light.h"

namespace vdbcloud {

extern const LightKind sun_kind, lamp_kind, spot_kind;

}  // namespace vdbcloud
