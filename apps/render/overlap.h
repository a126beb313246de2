#pragma once
// Media of one file that overlap and share its light.
#include "scene.h"

#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/optics/joined_medium.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// The volumes of the media of one file (app::read_inputs): `first` and those that follow.
struct Overlap {
    size_t first = 0, count = 1;

    bool several() const { return count > 1; }
    std::vector<MediumPart> parts(const Scene&) const;
};

/// The overlap of which `files[v]` is one, among the files and volumes of a scene.
Overlap overlap_of(const std::vector<GridFile>& files, size_t v);

/// All overlaps, in the order of the files.
std::vector<Overlap> overlaps_of(const std::vector<GridFile>& files);

/// True if phi of a file is that of several media.
bool is_mixture(const GridBase& phi);

/// Gives each volume of an overlap the collided light of its first volume, with the delta scaling of its own phase
/// function: their sources add up to that of the joined medium. Throws UsageError if the light was computed for other
/// media.
void share_collided(const GridFile&, const Overlap&, Scene&);

/// exp(-tau) towards a light through all media of an overlap, in the scaled medium of their collided light: the file's
/// where it fits, else computed.
GridBasePtr overlap_light(app::App&, const GridFile&, const Overlap&, const Scene&, const Light&,
                          const TransmittanceOptions&);

}  // namespace vdbcloud
