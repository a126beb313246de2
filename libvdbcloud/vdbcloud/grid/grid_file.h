#pragma once
// The contents of one .vdb file: grids and metadata. A stage takes a GridFile and returns a GridFile.
#include "vdbcloud/core/fwd.h"

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

/// All contents of one .vdb file. A stage replaces or adds the grids that it computes and keeps all other grids, so
/// a pipe of stages loses no grid.
struct GridFile {
    std::string path;                   ///< for messages: the path given by the user, "-" for standard input
    std::vector<GridBasePtr> grids;     ///< in file order; names need not be unique
    std::shared_ptr<MetaMap> metadata;  ///< of the file; never null
};

/// The first grid called `name`; for "NAME[k]" the k-th grid (from 0) called NAME. Null if there is none.
GridBasePtr find_grid(const GridFile&, const std::string& name);

/// Replaces the first grid of the same name; without such a grid, appends the given grid.
void put_grid(GridFile&, const GridBasePtr&);

/// Removes every grid for whose name the predicate returns true.
void remove_grids(GridFile&, const std::function<bool(const std::string&)>&);

}  // namespace vdbcloud
