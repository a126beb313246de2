#pragma once
// The fingerprint of a .vdb file. Private to file/.
#include "vdbcloud/file/descriptor_stream.h"
#include "vdbcloud/grid/digest.h"

namespace vdbcloud {

/// Digest of all bytes of a .vdb file except its identifier, which may be random. Throws std::system_error.
Digest file_digest(const ReadAt&);

}  // namespace vdbcloud
