#pragma once
// The camera, from options and scene.
#include "scene.h"

namespace vdbcloud {

/// The camera of --camera, --look-at, --direction and --ortho-width. Values that are not given come from framing the
/// scene, or a unit box for an empty scene. Without --camera it stands before all that rays can see, the thinnest
/// matter too. Says if matter is behind it.
Camera chosen_camera(app::App&, const RenderOptions&, const LoadedScene&, const ImageSize&);

}  // namespace vdbcloud
