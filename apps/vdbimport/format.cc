#include "format.h"

#include <algorithm>
#include <cctype>
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

/// True if the first line that is neither empty nor a comment begins with a letter.
bool names_columns(const std::string& bytes)
{
    for (size_t at = 0; at < bytes.size();) {
        const size_t first = bytes.find_first_not_of(" \t\r\n\"\xef\xbb\xbf", at);
        if (first == std::string::npos) return false;
        if (bytes[first] != '#') return std::isalpha(static_cast<unsigned char>(bytes[first])) != 0;
        at = std::min(bytes.find('\n', first), bytes.size());
    }
    return false;
}

Format by_content(const std::string& bytes)
{
    for (const char* magic : {"CDF\1", "CDF\2", "CDF\5", "\211HDF\r\n\032\n"})
        if (begins(bytes, magic)) return Format::NetCdf;
    if (begins(bytes, "\x93NUMPY")) return Format::Npy;
    if (begins(bytes, "ply\n") || begins(bytes, "ply\r")) return Format::Ply;
    if (begins(bytes, "NanoVDB")) return Format::NanoVdb;
    if (begins(bytes, " BDV")) return Format::Points;
    return Format::Automatic;
}

}  // namespace

const std::vector<std::pair<std::string, Format>>& format_words()
{
    static const std::vector<std::pair<std::string, Format>> all = {
        {"auto", Format::Automatic}, {"table", Format::Table},    {"netcdf", Format::NetCdf}, {"npy", Format::Npy},
        {"raw", Format::Raw},        {"shdom", Format::Shdom},    {"ply", Format::Ply},       {"csv", Format::Csv},
        {"points", Format::Points},  {"nanovdb", Format::NanoVdb}};
    return all;
}

Format format_of(const std::string& path)
{
    if (path == "-") return Format::Table;
    const std::string bytes = first_bytes(path);
    if (const Format format = by_content(bytes); format != Format::Automatic) return format;
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    static const std::vector<std::pair<std::string, Format>> all = {
        {".nc", Format::NetCdf}, {".nc4", Format::NetCdf}, {".cdf", Format::NetCdf},
        {".npy", Format::Npy},   {".raw", Format::Raw},    {".prp", Format::Shdom},
        {".ply", Format::Ply},   {".vdb", Format::Points}, {".nvdb", Format::NanoVdb}};
    for (const auto& [known, format] : all)
        if (extension == known) return format;
    if (extension == ".csv" && names_columns(bytes)) return Format::Csv;
    return Format::Table;
}

std::string word_of(Format format)
{
    for (const auto& [word, meaning] : format_words())
        if (meaning == format) return word;
    return {};
}

}  // namespace vdbcloud
