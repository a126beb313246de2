#pragma once
// Soundings as small text tables.
#include "vdbcloud/sim/parameters.h"

#include <string>

namespace vdbcloud::sim {

/// Reads a table: lines "z theta q u v" in m, K (liquid water potential temperature), g/kg (total water), m/s, m/s, by
/// increasing z; '#' begins a comment; a line "pressure HPA" gives the pressure at the floor [hPa]. u and v may be left
/// out. Throws InputError "NAME: line N: ..." for any other text.
Sounding read_sounding(const std::string& name, const std::string& text);

/// Adds a wind that changes with height: u += u0 + shear_u z, and the same for v.
void add_wind(Sounding&, double u0, double v0, double shear_u, double shear_v);

}  // namespace vdbcloud::sim
