#pragma once
// The contents of one .vdb: its grids and its metadata, as a stage receives them and passes them on.
#include "vdbcloud/core/fwd.h"

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

/// Everything one .vdb holds. A stage changes or adds what it makes and passes the rest on, so a pipe carries
/// it all.
struct GridFile {
    std::string path;                   ///< as the user named it, "-" for standard input: for messages
    std::vector<GridBasePtr> grids;     ///< in file order; names need not be unique
    std::shared_ptr<MetaMap> metadata;  ///< of the file; never null
};

/// The grid called `name`, or `name[k]` for the k-th (from 0) of that name; null if there is none.
GridBasePtr find_grid(const GridFile&, const std::string& name);

/// Replaces the grid of the same name, or adds it at the end.
void put_grid(GridFile&, const GridBasePtr&);

/// Removes every grid whose name passes the test.
void remove_grids(GridFile&, const std::function<bool(const std::string&)>&);

}  // namespace vdbcloud
