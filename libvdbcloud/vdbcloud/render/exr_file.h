#pragma once
// Pictures as .exr, in memory, so that every write to the disk is checked. Private to render/.
//
// Through OpenEXR itself: OpenImageIO brings 240 shared libraries, whose loading takes a program 0.2 s.
#include "vdbcloud/render/whole_file.h"

#include <OpenEXR/ImfHeader.h>

#include <string>
#include <vector>

namespace vdbcloud {

struct ImageMetadata;

/// A channel of a file and where its values are: those of a row `stride` floats apart, rows one after the other.
struct ExrChannel {
    std::string name;
    bool half;
    const float* values;
    size_t stride;
};

/// The file of the header's data window, scan lines; halves are rounded to the nearest. The header's channels are set
/// here. Throws IoError, path first.
Bytes encoded_exr(const std::string& path, Imf::Header, const std::vector<ExrChannel>&);

/// Software, creator, history, the texts and numbers.
void set_attributes(Imf::Header&, const ImageMetadata&);

/// A text attribute; empty if there is none, or one of another type.
std::string text_attribute(const Imf::Header&, const char* key);
void set_text_attribute(Imf::Header&, const std::string& key, const std::string& text);
void set_number_attribute(Imf::Header&, const std::string& key, double number);

/// A picture of scan lines or tiles: the first part of its file. Values row by row, the channels of a pixel together,
/// in the header's order.
struct ExrPicture {
    Imf::Header header;
    std::vector<float> values;
};

/// Throws IoError, path first: the file cannot be read, is no regular file, claims more pixels than its bytes can hold,
/// or more than the memory that is left (picture_bytes.h).
ExrPicture read_exr(const std::string& path);

}  // namespace vdbcloud
