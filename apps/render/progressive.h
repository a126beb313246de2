#pragma once
// The picture that --progressive shows while it is computed.
#include "output.h"

namespace vdbcloud {

/// Writes the .png of the command each time it is called, in the place of the one before; none without --progressive.
/// Keeps references to all arguments. Sets RenderOptions::shown.
ShowPicture shower(app::App&, RenderOptions&, const LoadedScene&, const CameraView&);

/// Reports and prints how far a picture came whose time was limited.
void report_coarseness(app::App&, const RenderOptions&, const CoarseReport&, const Film&);

}  // namespace vdbcloud
