#pragma once
// Which lights a medium that repeats without end can have.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/scene/light.h"

#include <array>

namespace vdbcloud {

/// Throws InputError unless the light is at infinity and its rays leave a medium that repeats along `periodic` index
/// axes. A lamp would have to stand in each copy; light along the repeating axes has crossed matter without end.
void require_light_that_leaves(const Light&, const Affine& index_from_world, const std::array<bool, 3>& periodic);

}  // namespace vdbcloud
