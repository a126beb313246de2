#pragma once
// Where a film keeps the layers of a rendering, and how the result of a ray goes there. Private to render/.
#include "vdbcloud/render/media.h"

#include <vector>

namespace vdbcloud {

/// First channel of each layer of render_layers(); -1 where the film lacks the layer.
struct LayerPlaces {
    /// Keeps a reference to the scene's sky.
    LayerPlaces(const Film&, const Scene&);

    /// Writes one ray's result to the channels of a sample. (x, y): the ray's place in the picture [pixels].
    void put(const RayResult&, const CameraView&, const Sky& background, double x, double y, const Vec3d& direction,
             double* out) const;

    int beauty, background, sky, depth, transmittance, multiple, emission, ground, solid;
    std::vector<int> direct;

private:
    const Sky& lighting_;
};

}  // namespace vdbcloud
