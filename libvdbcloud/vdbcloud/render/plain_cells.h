#pragma once
// The cells rule for the plainest scenes, several times as fast. Private to render/.
#include "vdbcloud/render/media.h"

namespace vdbcloud {

/// Whether a scene is one grey volume under distant lights, without colour, emission or shadow rays, in a medium that
/// does not repeat, rendered by the cells rule with one part a cell. Collided light and delta scaling are allowed.
/// Lattices of the grids are not looked at.
bool is_plain(const Scene&, const IntegratorOptions&);

/// Sets the fields of a plain scene: depth of each light, phi, flux and moments, whichever there are. False, and none
/// set, where a grid is not on the lattice of the density, or coloured light has a depth for each channel.
bool add_plain_fields(const Volume&, const BrickMap::Map& depth_of, PreparedVolume&);

/// The rule of cells.cc for a scene that has plain fields. All that a ray reads in a cell lies together, and cells are
/// computed four at a time. Equal to the general path to rounding: 1e-12 of a picture.
std::unique_ptr<RayIntegrator> make_plain_cells_integrator(const PreparedScene&);

}  // namespace vdbcloud
