#pragma once
// The light in the delta-scaled medium that phi and flux belong to.
#include "app.h"

#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/optics/joined_medium.h"

namespace vdbcloud::app {

/// exp(-tau') towards a light in the medium of extinction (1 - delta_f w0) sigma_t. Computed from the density, because
/// a stored transmittance can be 0 in single precision where the scaled one is not. With a tint (`colour`, may be null)
/// w0 varies, and so does the scaled density, by channel: the grid is then vec3s.
GridBasePtr scaled_light_grid(App&, const FloatGrid& density, const Vec3SGrid* colour, const Medium&,
                              const DeltaScaling&, const Light&, const TransmittanceOptions& = {});

/// exp(-tau') towards a light through media that overlap, each scaled by its own phase function: float where the
/// channels have one extinction, else vec3s. Its metadata name the media (schema::mixture).
GridBasePtr mixed_light_grid(App&, const std::vector<MediumPart>&, const std::vector<DeltaScaling>&, const Light&,
                             const TransmittanceOptions& = {});

}  // namespace vdbcloud::app
