#pragma once
// What render_image() would do and hold, without doing so.
#include "vdbcloud/core/workload.h"
#include "vdbcloud/render/integrator.h"

namespace vdbcloud {

/// Events of data/unit_costs.txt of a picture: `cost` from render_image(), the film's values, and the maps of the
/// scene.
Workload render_work(const Film&, const Scene&, const IntegratorOptions&, const RenderCost& cost);

/// Work of a picture, by a pilot of about a thousand rays spread over the window: the cells that rays cross, and how
/// many of these are hidden. Light paths are followed, four samples a ray; without a number of samples the noise of the
/// pilot says when a noise target is met. Light grids of the scene are not used and may be missing.
RenderCost expected_cost(const Film&, const Scene&, const CameraView&, const SamplingOptions&,
                         const IntegratorOptions&);

/// Memory of a rendering beyond the scene's grids and the film [bytes].
double render_bytes(const Film&, const Scene&, const IntegratorOptions&);

}  // namespace vdbcloud
