#include "vdbcloud/core/error.h"
#include "vdbcloud/render/image_out.h"

#include <filesystem>

namespace vdbcloud {

ImageFormat image_format(const std::string& path)
{
    if (path == "-") return ImageFormat::Exr;
    std::error_code failed;
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    if (extension == ".exr") return ImageFormat::Exr;
    if (extension == ".png") return ImageFormat::Png;
    if (std::filesystem::is_character_file(path, failed) || std::filesystem::is_fifo(path, failed))
        return ImageFormat::Exr;
    throw UsageError(printable(path) + ": expected a name that ends in .exr or .png");
}

}  // namespace vdbcloud
