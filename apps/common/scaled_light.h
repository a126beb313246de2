#pragma once
// The light in the delta-scaled medium that phi and flux belong to.
#include "app.h"

#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/delta_scaling.h"

namespace vdbcloud::app {

/// exp(-tau') towards a light in the medium of extinction (1 - f w0) sigma_t. From the density: a stored
/// transmittance is 0 in single precision where this one is not. With a tint (`colour`, may be null) w0 varies, and so
/// does the scaled density, by channel: the grid is then vec3s.
GridBasePtr scaled_light_grid(App&, const FloatGrid& density, const Vec3SGrid* colour, const Medium&,
                              const DeltaScaling&, const Light&, const TransmittanceOptions& = {});

}  // namespace vdbcloud::app
