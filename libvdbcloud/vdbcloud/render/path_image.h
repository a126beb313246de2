#pragma once
// Pictures by light paths: path.h for each sample. Private to render/.
#include "vdbcloud/render/integrator.h"

namespace vdbcloud {

/// render_image() for Integrator::Path. Sample k of a pixel is a function of (seed, i, j, k): its place within the
/// pixel's filter, too, is random, so that all samples are independent.
RenderCost render_paths(Film&, const Scene&, const CameraView&, const SamplingOptions&, const IntegratorOptions&,
                        const Progress& = {});

}  // namespace vdbcloud
