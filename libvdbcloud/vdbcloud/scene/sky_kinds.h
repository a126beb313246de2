#pragma once
// The kinds of sky, each defined in a file of its own. sky.cc has the table of them. Private to scene/.
#include "vdbcloud/scene/sky.h"

namespace vdbcloud {

extern const SkyKind gradient_kind, preetham_kind, environment_kind;

}  // namespace vdbcloud
