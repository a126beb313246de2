#pragma once
// Hostile contents of files. Each function makes one from a healthy file and says in `what` what it did.
#include "support/damage.h"

#include <string>

namespace vdbcloud::test {

/// A .vdb of another meaning: keys of our metadata missing, of another type, not finite or huge; names of grids with
/// escapes; other value types, transforms, backgrounds, values, tiles and places.
std::string hostile_grids(const std::string& vdb_path, Dice&, std::string& what);

/// Compressed parts of a .vdb that claim to be other sizes than they are.
std::string hostile_compression(std::string bytes, Dice&, std::string& what);

/// A .vdb with `count` grids of one voxel.
std::string many_grids(int count);

/// Lines of text (configurations, tables, soundings) with numbers and lines that nobody writes.
std::string hostile_text(const std::string& text, Dice&, std::string& what);

/// A picture by its extension. The header of an exr, png, hdr or ppm claims another size or another number of channels,
/// and checksums are those of the claim; others are damaged.
std::string hostile_picture(const std::string& bytes, const std::string& extension, Dice&, std::string& what);

/// A checkpoint of cloudsim with another value and the checksum of what it holds.
std::string hostile_checkpoint(std::string bytes, Dice&, std::string& what);

}  // namespace vdbcloud::test
