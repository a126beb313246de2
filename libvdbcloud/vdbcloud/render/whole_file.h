#pragma once
// Files of pictures that appear whole or not at all. Private to render/.
#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

using Bytes = std::vector<unsigned char>;

/// Writes what `make` returns, whole or not at all; "-" is standard output. Throws IoError, path first.
void write_picture_file(const std::string& path, bool no_clobber, const std::function<Bytes()>& make);

}  // namespace vdbcloud
