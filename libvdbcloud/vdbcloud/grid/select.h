#pragma once
// Naming the grids of a file, for messages and for choosing among them.
#include "vdbcloud/grid/grid_file.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// What to call each grid, in file order: its name, or NAME[k] where several bear it.
std::vector<std::string> grid_labels(const GridFile&);

/// The labels as a list in quotes, cut to a length that can be read; "no grids" if there are none.
std::string grid_list(const GridFile&);

/// find_grid, where it must be there and be meant alone: an InputError lists what the file has.
GridBasePtr chosen_grid(const GridFile&, const std::string& name);

/// The first grid that bears an alias of `role` (exactly, else but for upper and lower case); null if there
/// is none.
GridBasePtr aliased_grid(const GridFile&, const std::string& role);

/// Finds a grid of another role by its aliases (schema::aliases); null if absent. `asked` as above.
GridBasePtr grid_of(const GridFile&, const std::string& role, const std::string& asked = {});

}  // namespace vdbcloud
