#pragma once
// The camera, from options and scene.
#include "scene.h"

namespace vdbcloud {

/// The camera of --camera, --look-at, --direction and --ortho-width. Values that are not given come from framing the
/// scene, or a unit box for an empty scene.
Camera chosen_camera(const RenderOptions&, const LoadedScene&, const ImageSize&);

}  // namespace vdbcloud
