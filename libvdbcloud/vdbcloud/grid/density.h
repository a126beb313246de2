#pragma once
// The density of a file: which grid it is, and whether its values can be used.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"

#include <string>

namespace vdbcloud {

/// The density of a file as floats. `asked` is the user's choice (NAME or NAME[k]), or empty: then the first
/// alias that is there, else the only fog volume (float, class fog or unknown). Where several grids bear the
/// name that fits and the user did not choose, an error that lists NAME[0], NAME[1], ... A level set or
/// points are refused with a sentence. Double, and half, come as float; a grid of another scalar type is
/// refused. Negative values become 0 with one warning that counts them; a value that is not finite is an
/// InputError with its coordinate. Active tiles stay tiles. The grid that is returned is a copy only if
/// something had to change; the file's entry is then replaced by it.
FloatGridPtr density_of(GridFile&, const std::string& asked = {}, const Warn& = {});

}  // namespace vdbcloud
