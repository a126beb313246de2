#pragma once
// --periodic: along which axes the medium repeats, from the command line or from the results in a file.
#include "app.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// Axes of the index space along which a medium repeats.
using Axes = std::array<bool, 3>;

/// --periodic, bound to `text`, which periodic_axes() reads.
Option declare_periodic(App&, std::string& text, const std::string& group);

/// The axes asked for; without any those that the results in the files (transmittance, phi, series) were computed for,
/// else none. Throws UsageError for a text other than "none" or one or two of the letters x, y, z, and where nothing is
/// asked for and results differ.
Axes periodic_axes(const std::string& asked, const std::vector<GridFile>&);

}  // namespace vdbcloud::app
