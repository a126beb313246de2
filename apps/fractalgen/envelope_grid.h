#pragma once
// What the cloud fills: a body, or a grid of another file.
#include "options.h"

#include "vdbcloud/fractal/envelope.h"

namespace vdbcloud::app {

/// The grid of --envelope-from: the named one, else a density, else a level set. Null without a file. Throws InputError
/// for a level set that is not of floats.
FloatGridPtr mask_of(App&, const Options&);

/// Bounds of the mask with room for what noise adds.
Box bounds_around(const FloatGrid& mask, const Options&);

/// The mask (may be null: the body of --envelope) within the domain, with room around it for what noise adds.
EnvelopePtr envelope_of(const Options&, const Domain&, const FloatGrid* mask);

}  // namespace vdbcloud::app
