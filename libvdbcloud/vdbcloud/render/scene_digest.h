#pragma once
// A fingerprint of what a picture of light paths shows: parts of one run agree in it.
#include "vdbcloud/render/integrator.h"

#include <string>

namespace vdbcloud {

/// XXH3 (128 bits) in hex of everything that decides the value of a sample of Integrator::Path except seed and index:
/// media, lights, sky, background, camera, size, pixel filter, and whether R, G, B hold the background.
std::string scene_digest(const Scene&, const CameraView&, const SamplingOptions&, bool over_background);

}  // namespace vdbcloud
