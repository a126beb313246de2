#pragma once
// Numbers with names, units and dimensions as a netCDF file, for xarray, ncview and their like.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud {

/// A variable of doubles. One that has the name of its only dimension is that dimension's coordinate.
struct NetcdfColumn {
    std::string name;
    std::string unit;                ///< "" of ratios
    std::string meaning;             ///< for people
    std::vector<size_t> dimensions;  ///< indices of NetcdfTables::dimensions, the slowest first
    std::vector<double> values;      ///< the last dimension fastest
};

struct NetcdfTables {
    std::vector<std::pair<std::string, size_t>> dimensions;  ///< names and lengths, above 0
    std::vector<NetcdfColumn> columns;
    std::vector<std::pair<std::string, std::string>> attributes;  ///< of the file, as text
};

/// Writes the classic format with 64-bit offsets; the file appears whole or not at all. Equal tables make equal bytes.
/// Throws IoError.
void write_netcdf(const std::string& path, const NetcdfTables&);

}  // namespace vdbcloud
