#pragma once
// Bytes of .npy files.
#include <string>

namespace vdbcloud::test {

/// `shape` in numpy's words: "(2, 3, 4)".
inline std::string npy_bytes(const std::string& type, const std::string& shape, bool fortran,
                             const std::string& numbers)
{
    std::string header =
        "{'descr': '" + type + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }";
    while ((header.size() + 11) % 64 != 0) header += ' ';
    header += '\n';
    return std::string("\x93NUMPY\1\0", 8) + char(header.size() % 256) + char(header.size() / 256) + header + numbers;
}

}  // namespace vdbcloud::test
