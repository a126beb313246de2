#pragma once
// What OpenImageIO does for the library, in a module that is opened at run time: OpenImageIO brings 240 shared
// libraries, whose loading takes a program 0.2 s and 120 MB. Private to render/.
#include "vdbcloud/render/image_in.h"
#include "vdbcloud/render/image_out.h"
#include "vdbcloud/render/whole_file.h"

#include <functional>
#include <string>

namespace vdbcloud {

/// A picture of three channels.
struct PngPicture {
    int width, height;
    int bits;            ///< 8 or 16
    const void* values;  ///< uint8_t or uint16_t, row by row
    double pixel_aspect;
    bool linear;  ///< else sRGB
    const ImageMetadata& metadata;
};

/// What a picture claims to be.
struct PictureSize {
    int width, height, channels;
    uint64_t pixel_bytes;  ///< as the file stores them, unpacked
};

/// The module's functions return what went wrong, empty if nothing did.
struct PictureModule {
    std::string (*encode_png)(const PngPicture&, Bytes& file);
    /// Calls `check` before any pixel is decoded; what it throws passes through.
    std::string (*read)(const std::string& path, const std::function<void(const PictureSize&)>& check, Pixels&);
};

/// The module, opened by the first call and kept. The loader looks for it where the program says (its RUNPATH). Throws
/// IoError, `path` first: the module or its libraries are not there, or the memory limit leaves no room for them.
/// Thread-safe.
const PictureModule& picture_module(const std::string& path);

/// The name of the module's file, and of the function in it that returns its PictureModule.
inline constexpr const char* picture_module_file = "vdbcloud_openimageio.so";
inline constexpr const char* picture_module_symbol = "vdbcloud_picture_module_1";

}  // namespace vdbcloud
