#pragma once
// Numbers as text without loss.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud {

/// The shortest text that reads back as exactly `x`.
std::string shortest(double x);
std::string shortest(const Vec3d&);  ///< "x,y,z"

}  // namespace vdbcloud
