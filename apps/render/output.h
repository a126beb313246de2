#pragma once
// What render writes and reports: pictures that say how they were made, and figures.
#include "scene.h"

namespace vdbcloud {

/// Attributes of the pictures.
ImageMetadata image_metadata(const app::App&, const RenderOptions&, const LoadedScene&, double exposure);

/// Fills the report of a rendering: picture, camera, media, lights, cost.
void report_picture(app::App&, const RenderOptions&, const LoadedScene&, const CameraView&);
void report_cost(app::App&, const RenderCost&, double exposure);

/// What --dry-run says: memory [bytes] and a rough time [s] of the march, from boxes and pixels alone.
void report_estimate(app::App&, const RenderOptions&, const LoadedScene&, const Film&);

}  // namespace vdbcloud
