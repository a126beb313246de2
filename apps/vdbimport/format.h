#pragma once
// The kinds of files that vdbimport reads, and how it tells them.
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud {

enum class Format { Automatic, Table, NetCdf, Npy, Raw, Shdom, Ply, Csv, Points, NanoVdb };

/// The words of --format.
const std::vector<std::pair<std::string, Format>>& format_words();

/// The kind of a file: by its first bytes, else by its extension, else a table. A path that cannot be read is judged by
/// its extension.
Format format_of(const std::string& path);

/// The word for a format.
std::string word_of(Format);

}  // namespace vdbcloud
