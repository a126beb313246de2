#pragma once
// Pictures of other programs, as numbers.
#include <string>
#include <vector>

namespace vdbcloud {

/// Pixels row by row from the top, the channels of a pixel together.
struct Pixels {
    int width = 0, height = 0, channels = 0;
    std::vector<float> values;
};

/// Reads a picture in any format that OpenImageIO knows; integers become 0 to 1. Throws IoError, path first: the file
/// cannot be read; a side is above 16384 pixels or there are more than 2^28 values; the file claims more pixels than
/// its bytes can hold.
Pixels read_pixels(const std::string& path);

}  // namespace vdbcloud
