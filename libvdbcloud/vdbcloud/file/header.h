#pragma once
// A first look at a .vdb, cheap and without OpenVDB's reader: is what its header claims possible at all?
#include <cstdint>
#include <string>

namespace vdbcloud {

/// Checks magic number, format version, the counts and lengths of the file's metadata, and for every grid whose
/// place is known its name, type and extent in the file. Throws IoError beginning with `path`.
void check_header(const std::string& path, int descriptor, uint64_t size);

/// True if `bytes` (4 or more) begin as a .vdb does.
bool has_magic(const void* bytes);

}  // namespace vdbcloud
