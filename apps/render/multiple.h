#pragma once
// Light that is scattered more than once and that the input does not bring: computed, or told.
#include "scene.h"

namespace vdbcloud {

/// --multiple: computes the multiple scattering of the scene's only volume as `p1solve --iterations 3` does, and puts
/// its grids into `file` and into the volume. A dry run counts the work. Throws UsageError for several files and for a
/// file that has multiple scattering, ConvergenceError as p1solve.
void add_multiple(app::App&, const RenderOptions&, std::vector<GridFile>&, LoadedScene&);

/// The share of scattered light that multiple scattering of the scene's first volume brings, as far as it decides
/// whether that is worth computing.
ShareFound share_of_multiple(app::App&, const RenderOptions&, const LoadedScene&);

/// Says which share of the light a picture of single scattering leaves out (scatter/expected_share.h), and reports it.
/// Finds nothing with --quiet and without --json, where nobody reads it.
void tell_left_out(app::App&, const RenderOptions&, const LoadedScene&);

}  // namespace vdbcloud
