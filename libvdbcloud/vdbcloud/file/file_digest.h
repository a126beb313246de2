#pragma once
// The fingerprint of a .vdb file.
#include "vdbcloud/grid/digest.h"

namespace vdbcloud {

/// Of all bytes of a .vdb but its identifier, which a writer may draw at random. Throws std::system_error.
Digest file_digest(int descriptor);

}  // namespace vdbcloud
