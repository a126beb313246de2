#pragma once
// Which effects a picture has in play.
#include "scene.h"

#include "vdbcloud/grid/grid_file.h"

namespace vdbcloud {

/// The effects asked for. Throws UsageError where the list contradicts other options.
EffectsAsked checked_effects(const RenderOptions&);

/// Where p1solve left multiple scattering out, light paths of --gather have nothing to end in: they become whole paths.
void end_paths_in_solution(app::App&, RenderOptions&, const std::vector<GridFile>&);

/// The sky that lights media of light paths, and solids: the one that lit the file, the one asked for, or the one that
/// is seen. `loaded`: lights, up axis, sky and solids.
Sky lighting_sky(const RenderOptions&, const LoadedScene& loaded, const Sky& background);

/// The effects in play, of a scene whose lights are chosen and whose light grids are not yet there. `solids` and
/// `ground`: those of the scene, whether the request leaves them out or not.
Effects effects_of(app::App&, const RenderOptions&, const std::vector<GridFile>&, const LoadedScene&,
                   const std::vector<Solid>& solids, const std::optional<double>& ground);

/// Takes out of the scene what is not in play. Throws UsageError where multiple scattering of a file holds the light of
/// a sky or a ground that the request leaves out.
void apply(const Effects&, RenderOptions&, LoadedScene&);

}  // namespace vdbcloud
