#pragma once
// Tables of large-scale forcing.
#include "vdbcloud/sim/parameters.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

/// Reads a table. Its first line names the columns with their units: "z[m] w_ls[cm/s] u_g[m/s] v_g[m/s]
/// dtheta_l[K/day] dq_t[g/kg/day]", z first, of the others any. Words are between spaces or commas. "-" stands for the
/// value on the line between the values around it. Text after # is a comment. Throws InputError that begins with
/// `name`.
LargeScale read_large_scale(const std::string& name, const std::string& text);

/// The forcings of data/forcings, compiled in. Throws InputError that lists the names.
LargeScale large_scale_named(const std::string& name);

}  // namespace vdbcloud::sim
