#pragma once
// What render writes into its pictures and its report: how the picture was made, counts, and estimates.
#include "plan.h"
#include "scene.h"

namespace vdbcloud {

/// Attributes of the pictures.
ImageMetadata image_metadata(const app::App&, const RenderOptions&, const LoadedScene&, double exposure);

/// Adds which samples a picture of light paths holds, and of what, so that exrmerge can put parts together.
void stamp_samples(ImageMetadata&, const Scene&, const CameraView&, const RenderOptions&, uint64_t samples);

/// Reports and prints how many samples were taken and what noise they leave.
void report_passes(app::App&, const PassReport&);

/// What the files of a picture take beside their values: .png opens a library.
Workload writing_work(const RenderOptions&);

/// Adds camera, picture, lights and media to the report.
void report_picture(app::App&, const RenderOptions&, const LoadedScene&, const CameraView&);
/// Adds counts, accuracy and exposure to the report. Warns of rays that missed their tolerance.
void report_cost(app::App&, const RenderCost&, const Workload&, double exposure);

/// Memory of the picture, without events.
app::Plan least_plan(const RenderOptions&, const LoadedScene&, const Film&);

/// Reports what --dry-run estimates, by a pilot of rays.
void report_estimate(app::App&, const RenderOptions&, const LoadedScene&, const Film&, const CameraView&);

}  // namespace vdbcloud
