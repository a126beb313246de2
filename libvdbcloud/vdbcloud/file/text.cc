#include "vdbcloud/file/text.h"

#include "vdbcloud/core/error.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>

namespace vdbcloud {

std::string read_bytes(const std::string& path, uint64_t max_bytes, const std::string& what)
{
    const std::string name = path == "-" ? "standard input" : printable(path, 4096);
    std::ifstream file;
    if (path != "-") file.open(path, std::ios::binary);
    std::istream& in = path == "-" ? std::cin : file;
    if (!in) throw IoError(name + ": cannot read it: " + std::strerror(errno));
    std::string text, block(1 << 16, ' ');
    while (in.read(block.data(), std::streamsize(block.size())) || in.gcount() > 0) {
        text.append(block, 0, size_t(in.gcount()));
        if (text.size() > max_bytes)
            throw IoError(name + ": has more than " + std::to_string(max_bytes) + " bytes: expected a smaller " + what);
    }
    // std::cin reads by the C library, and takes its failure for the end.
    if (in.bad() || (path == "-" && std::ferror(stdin)))
        throw IoError(name + ": cannot read it: " + (errno == EBADF ? "it is closed" : std::strerror(errno)));
    return text;
}

std::string read_text(const std::string& path, uint64_t max_bytes, const std::string& what)
{
    std::string text = read_bytes(path, max_bytes, what);
    const std::string byte_order_mark = "\xef\xbb\xbf";
    return text.compare(0, 3, byte_order_mark) == 0 ? text.substr(3) : text;
}

}  // namespace vdbcloud
