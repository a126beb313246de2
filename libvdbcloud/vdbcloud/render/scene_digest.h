#pragma once
// A fingerprint of what a picture of light paths shows: parts of one run agree in it.
#include "vdbcloud/render/integrator.h"

#include <string>

namespace vdbcloud {

/// XXH3 (128 bits) in hex of everything that decides the value of a sample of Integrator::Path except seed and index:
/// media, lights, sky, background, camera, size, pixel filter, and whether R, G, B hold the background. With
/// IntegratorOptions::vertices also that number and the grids of light.
std::string scene_digest(const Scene&, const CameraView&, const SamplingOptions&, const IntegratorOptions&);

}  // namespace vdbcloud
