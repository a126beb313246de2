#pragma once
// What stands about the media of a picture: the axis that points up, the sky, the ground and the lights.
#include "scene.h"

#include <vector>

namespace vdbcloud {

/// The axis asked for, else the one that the files say: read_inputs() has compared them.
UpAxis up_of(app::App&, const RenderOptions&, std::vector<GridFile>&);

/// The sky that lit the files' media. Throws UsageError if it stands over another axis than the picture's.
void choose_sky(const RenderOptions&, const std::vector<GridFile>&, LoadedScene&);

/// The ground beneath the media: the one asked for, else that of the file's multiple scattering, with its light.
/// Throws UsageError for a solution over another axis than the picture's.
void choose_ground(const RenderOptions&, const std::vector<GridFile>&, LoadedScene&);

/// The lights asked for, else those of the files, else a sun if nothing else lights the scene.
void choose_lights(app::App&, const RenderOptions&, const std::vector<GridFile>&, LoadedScene&);

}  // namespace vdbcloud
