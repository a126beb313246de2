#pragma once
// The light of several inputs: each medium shades the others.
#include "options.h"

#include "vdbcloud/grid/grid_file.h"

#include <vector>

namespace vdbcloud {

/// True if more than one volume of the scene holds density.
bool has_several_media(const Scene&);

/// Throws UsageError if a file brings multiple scattering (phi or a series), and a medium besides its own has density
/// or emission: light that is exchanged between the two is in neither. An input without density and without emission
/// may stay, as it neither scatters nor shines.
void require_one_solution(const std::vector<GridFile>&, const Scene&);

/// The transmittance grid of volume `v` towards a light through all media. `own`, which may be null: the grid of that
/// volume alone, which is taken if no other medium shades the volume. A grid that is computed has as many points a
/// voxel as `own`.
GridBasePtr shared_light_grid(app::App&, const Scene&, size_t v, const Light&, const GridBasePtr& own,
                              const RenderOptions&);

}  // namespace vdbcloud
