#pragma once
// A first look at a .vdb, cheap and without OpenVDB's reader: is what its header claims possible at all?
#include <cstdint>
#include <string>

namespace vdbcloud {

/// Checks magic number, format version, the counts and lengths of the file's metadata, and for every grid whose
/// place is known its name, type and extent in the file. Throws IoError beginning with `path`.
void check_header(const std::string& path, int descriptor, uint64_t size);

/// True if `bytes` (4 or more) begin with the magic number of a .vdb.
bool has_magic(const void* bytes);

/// What messages say of a file that does not.
inline constexpr const char* wrong_magic =
    "not a .vdb file (wrong magic number). A NanoVDB file? nanovdb_convert in.nvdb out.vdb";

}  // namespace vdbcloud
