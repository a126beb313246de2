#pragma once
// The camera that options and scene make together.
#include "scene.h"

namespace vdbcloud {

/// What --camera, --look-at, --direction and --ortho-width give, the rest from framing the scene (a unit box
/// if there is nothing in it).
Camera chosen_camera(const RenderOptions&, const LoadedScene&, const ImageSize&);

}  // namespace vdbcloud
