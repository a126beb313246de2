#pragma once
// Tables of numbers as text, which models of the atmosphere exchange.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

/// Rows of numbers, all of one length.
struct Table {
    size_t rows = 0, columns = 0;
    std::vector<double> values;  ///< row by row, each finite

    double at(size_t row, size_t column) const { return values[row * columns + column]; }
};

/// Reads numbers between blanks or commas, a row a line. Empty lines and lines that begin with # or ! do not count. The
/// path "-" is standard input. Throws IoError if the file cannot be read or has more than `max_bytes`; InputError, with
/// the line, for a word that is no finite number, for a row of another length than the first, and for an empty table.
Table read_table(const std::string& path, uint64_t max_bytes = uint64_t(1) << 26);

}  // namespace vdbcloud
