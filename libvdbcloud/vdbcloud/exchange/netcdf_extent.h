#pragma once
// How long a file of netCDF's classic formats has to be: the library takes what is missing at the end as zeros. Private
// to exchange/.
#include <cstdint>

namespace vdbcloud {

/// Bytes of header and values of an open file of a classic format (CDF-1, -2, -5), without padding after the header: a
/// whole file is at least as long. 0 for netCDF-4. Throws InputError.
uint64_t classic_extent(int file);

}  // namespace vdbcloud
