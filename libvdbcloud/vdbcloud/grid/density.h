#pragma once
// Finds the density and other scalar grids of a file, and checks their values.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"

#include <string>

namespace vdbcloud {

/// The density grid of a file, as floats.
///
/// `asked` is the user's choice (NAME or NAME[k]); the file's metadata keep it (schema::density_choice). If `asked` is
/// empty, the choice that the metadata hold counts, and a warning says so if there is no such grid; else
/// aliased_grid(). Without an alias, the density is the only fog volume: a float or double grid of class fog, else of
/// class unknown.
///
/// Double and half grids are converted to float. Negative values become 0, with one warning that counts them.
/// Values of inactive voxels that are not finite become the background, with another warning. Active
/// tiles stay tiles. The returned grid is a copy only if values or type had to change; the copy then replaces the
/// file's entry.
///
/// Throws InputError in these cases:
///   no grid can be the density, or several can; the message lists the grids, equal names as NAME[0], NAME[1], ...
///   the grid is a level set, holds points, or has a value type other than float and double;
///   the transform is not affine;
///   the value of an active voxel or the background is not finite; the message gives the voxel.
FloatGridPtr density_of(GridFile&, const std::string& asked = {}, const Warn& = {});

/// The scalar grid of a role beside the density (aliased_grid()), as floats: a double grid is converted. Null if there
/// is none, if it is empty, and, with a warning, for a level set, points, another value type or a transform that is not
/// affine. Values that are not finite: as density_of(). The returned grid is then a copy; the file's stays.
FloatGridPtr scalar_of(const GridFile&, const std::string& role, const Warn& = {});

}  // namespace vdbcloud
