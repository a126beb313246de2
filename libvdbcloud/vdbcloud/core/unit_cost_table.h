#pragma once
// The text of data/unit_costs.txt, which CMake compiles in. Private to core/.

namespace vdbcloud {

const char* unit_cost_table();

}  // namespace vdbcloud
