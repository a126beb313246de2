#include "format.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace vdbcloud {

namespace {

/// First bytes of a regular file; empty for others, which a look would change.
std::string first_bytes(const std::string& path)
{
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none)) return {};
    std::ifstream in(path, std::ios::binary);
    std::string bytes(4096, '\0');
    in.read(bytes.data(), std::streamsize(bytes.size()));
    bytes.resize(size_t(in.gcount()));
    return bytes;
}

bool begins(const std::string& bytes, const std::string& with) { return bytes.rfind(with, 0) == 0; }

Format by_content(const std::string& bytes)
{
    for (const char* magic : {"CDF\1", "CDF\2", "CDF\5", "\211HDF\r\n\032\n"})
        if (begins(bytes, magic)) return Format::NetCdf;
    if (begins(bytes, "\x93NUMPY")) return Format::Npy;
    return Format::Automatic;
}

}  // namespace

const std::vector<std::pair<std::string, Format>>& format_words()
{
    static const std::vector<std::pair<std::string, Format>> all = {
        {"auto", Format::Automatic}, {"table", Format::Table}, {"netcdf", Format::NetCdf},
        {"npy", Format::Npy},        {"raw", Format::Raw},     {"shdom", Format::Shdom}};
    return all;
}

Format format_of(const std::string& path)
{
    if (path == "-") return Format::Table;
    if (const Format format = by_content(first_bytes(path)); format != Format::Automatic) return format;
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    static const std::vector<std::pair<std::string, Format>> all = {{".nc", Format::NetCdf},  {".nc4", Format::NetCdf},
                                                                    {".cdf", Format::NetCdf}, {".npy", Format::Npy},
                                                                    {".raw", Format::Raw},    {".prp", Format::Shdom}};
    for (const auto& [known, format] : all)
        if (extension == known) return format;
    return Format::Table;
}

std::string word_of(Format format)
{
    for (const auto& [word, meaning] : format_words())
        if (meaning == format) return word;
    return {};
}

}  // namespace vdbcloud
