#pragma once
// Where light paths end when they are gathered: in the picture that the integrators without noise see. Private to
// render/.
#include "vdbcloud/render/surface_light.h"

namespace vdbcloud {

/// The scene with its transmittance grids and its multiple scattering, shared by all threads.
struct PathEndScene {
    /// Throws InputError for a medium without multiple scattering.
    explicit PathEndScene(const Scene&);

    IntegratorOptions options;  ///< one ray from each point of a solid
    PreparedScene media;
    SurfaceScene surfaces;
};

/// The last ray of a path. Holds scratch memory: one object per thread.
class PathEnd {
public:
    explicit PathEnd(const PathEndScene&);

    /// What arrives along a ray, as the picture has it: light scattered once or more, emission, the ground, solids, and
    /// the scaled optical depth. Not the lights themselves: light scattered once has the whole phase function and the
    /// factor of the forward peak (forward_peak.h), so the beam that it leaves is that of the true medium. Valid until
    /// the next call.
    const RayResult& along(const WorldRay&, PathRandom);

private:
    SurfaceLight march_;
    RayResult result_;
};

}  // namespace vdbcloud
