#pragma once
// The fingerprint of a .vdb file. Private to file/.
#include "vdbcloud/grid/digest.h"

namespace vdbcloud {

/// Digest of all bytes of a .vdb file except its identifier, which may be random. Throws std::system_error.
Digest file_digest(int descriptor);

}  // namespace vdbcloud
