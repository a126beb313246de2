#pragma once
// Finds the density grid of a file and checks its values.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"

#include <string>

namespace vdbcloud {

/// The density grid of a file, as floats.
///
/// `asked` is the user's choice (NAME or NAME[k]). If `asked` is empty, aliased_grid() selects the density.
/// Without an alias, the density is the only fog volume: a float or double grid of class fog, else of class unknown.
///
/// Double and half grids are converted to float. Negative values become 0, with one warning that counts them. Active
/// tiles stay tiles. The returned grid is a copy only if values or type had to change; the copy then replaces the
/// file's entry.
///
/// Throws InputError if several grids have the matching name and `asked` is empty (the message lists NAME[0],
/// NAME[1], ...), if the grid is a level set, holds points or another value type, if the transform is not affine, or if
/// a value is not finite (the message gives the voxel).
FloatGridPtr density_of(GridFile&, const std::string& asked = {}, const Warn& = {});

}  // namespace vdbcloud
