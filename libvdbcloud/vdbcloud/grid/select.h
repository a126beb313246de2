#pragma once
// Labels for the grids of a file, and choice of a grid by label or role.
#include "vdbcloud/grid/grid_file.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// The label of each grid, in file order: its name, or NAME[k] where several grids have that name.
std::vector<std::string> grid_labels(const GridFile&);

/// The labels in quotes, separated by commas, for a message; at most 600 characters. "no grids" for an empty file.
std::string grid_list(const GridFile&);

/// As find_grid(). Throws InputError, with the labels of the file, if no grid or several grids have this name.
GridBasePtr chosen_grid(const GridFile&, const std::string& name);

/// The first grid with an alias of `role` (schema::aliases), null if there is none. Exact matches come first, then
/// matches that ignore case. Throws InputError if several grids have the matching name.
GridBasePtr aliased_grid(const GridFile&, const std::string& role);

/// The grid of a role: chosen_grid(asked), or aliased_grid() if `asked` is empty. Velocity and colour may also be three
/// float grids (vel.x, vel.y, vel.z, ...), which are merged. Null if there is none. Throws InputError as both
/// functions.
GridBasePtr grid_of(const GridFile&, const std::string& role, const std::string& asked = {});

}  // namespace vdbcloud
