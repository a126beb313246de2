#pragma once
// The differences of two files, as JSON and as text.
#include "app.h"

#include "vdbcloud/grid/compare.h"

namespace vdbcloud {

/// Every grid and every difference, for --json.
nlohmann::json described(const FileDifference&);

/// One line a grid on standard error: standard output stays free for --json -.
void print_difference(app::App&, const FileDifference&);

}  // namespace vdbcloud
