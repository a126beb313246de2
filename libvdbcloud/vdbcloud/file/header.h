#pragma once
// Checks whether the header of a .vdb file is plausible: fast, and without OpenVDB's reader. Private to file/.
#include "vdbcloud/file/descriptor_stream.h"

#include <cstdint>
#include <string>

namespace vdbcloud {

/// Checks the magic number, the format version, and the counts and lengths of the file's metadata. For every grid whose
/// file position is known, checks its name, type and extent in the file. Throws IoError beginning with `path`.
void check_header(const std::string& path, const ReadAt&, uint64_t size);

/// True if `bytes` (4 or more) begin with the magic number of a .vdb file.
bool has_magic(const void* bytes);

/// The message for a file without the magic number.
inline constexpr const char* wrong_magic =
    "not a .vdb file (wrong magic number). A NanoVDB file? nanovdb_convert in.nvdb out.vdb";

}  // namespace vdbcloud
