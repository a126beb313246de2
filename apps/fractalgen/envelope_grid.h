#pragma once
// The envelope of the cloud: a body, or a grid of another file.
#include "inputs.h"
#include "options.h"

#include "vdbcloud/fractal/envelope.h"

namespace vdbcloud::app {

/// The grid of --envelope-from: the named one, else a density, else a level set. Null without a file. `world`
/// takes note of the file. Throws InputError for a level set that is not of floats, UsageError for a file that
/// contradicts the world.
FloatGridPtr mask_of(App&, const Options&, World& world);

/// Bounds of the mask, enlarged by the distance that noise can add.
Box bounds_around(const FloatGrid& mask, const Options&);

/// The envelope within the domain: the mask, or for a null mask the body of --envelope. Enlarged as bounds_around().
EnvelopePtr envelope_of(const Options&, const Domain&, const FloatGrid* mask);

}  // namespace vdbcloud::app
