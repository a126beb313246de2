#pragma once
// Arrays of numbers: .npy files, and raw bytes whose layout the user says.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

/// Layout of three-dimensional numbers in a file.
struct ArrayLayout {
    std::array<size_t, 3> shape{0, 0, 0};  ///< numbers along x, y, z
    std::string axes = "zyx";              ///< from the slowest index to the fastest
    std::string type = "f4";               ///< as of numpy: b1 i1 u1 i2 u2 i4 u4 i8 u8 f2 f4 f8
    bool big_endian = false;
};

/// x fastest.
struct Array {
    std::array<size_t, 3> shape{0, 0, 0};
    std::vector<float> values;
};

/// Sizes of the types of ArrayLayout [bytes]; 0 for other words.
size_t bytes_of_type(const std::string& type);

/// Numbers that fill the whole file. Throws IoError if it cannot be read, InputError, beginning with the path, for a
/// file of another size or more than 2^28 numbers.
Array read_raw(const std::string& path, const ArrayLayout&);

/// A .npy of version 1 to 3 with three dimensions, in C or Fortran order, named by `axes` from the first index to the
/// last. Throws as read_raw(), and for headers and types that are not of numbers.
Array read_npy(const std::string& path, const std::string& axes);

}  // namespace vdbcloud
