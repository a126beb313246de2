#pragma once
// The ground that camera rays see, of the integrators that march through media. Private to render/.
#include "vdbcloud/render/media.h"

namespace vdbcloud {

/// Adds to the result of a ray what the ground sends along it: Scene::ground_radiance times the ray's transmittance, in
/// the medium that the integrator attenuates by. A ray from beneath the ground sees nothing. Immutable: any number of
/// threads may use it.
class GroundLight {
public:
    /// Throws InputError for a ground without radiance or without a medium, and for a light that is not above it.
    explicit GroundLight(const Scene&);

    void add(const WorldRay&, RayResult&) const;

private:
    std::optional<Ground> ground_;
    Vec3d far_{0, 0, 0};              // radiance beyond the grid of the ground: its background
    std::optional<BrickMap> change_;  // of the radiance, against that
};

}  // namespace vdbcloud
