#pragma once
// The cells rule for the plainest scenes, several times as fast. Private to render/.
#include "vdbcloud/render/media.h"

namespace vdbcloud {

/// Whether a scene is one grey volume under distant lights, whose depths lie on the volume's own lattice,
/// without colour, emission, multiple scattering, scaling or shadow rays, in a medium that does not repeat.
bool is_plain(const PreparedScene&);

/// The rule of cells.cc for such a scene. Both depths are cubics of one cell there, and all colours share one sum.
std::unique_ptr<RayIntegrator> make_plain_cells_integrator(const PreparedScene&);

}  // namespace vdbcloud
