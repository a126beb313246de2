#include "vdbcloud/file/table.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/number_range.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/file/text.h"

#include <charconv>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr const char* separators = " \t\r,;";

/// Appends the numbers of a line; `where` names it in messages.
void add_numbers(const std::string& line, const std::string& where, std::vector<double>& to)
{
    for (size_t begin = line.find_first_not_of(separators); begin != std::string::npos;) {
        size_t end = line.find_first_of(separators, begin);
        if (end == std::string::npos) end = line.size();
        const char* first = line.data() + begin + (line[begin] == '+');
        double value = 0;
        const auto read = std::from_chars(first, line.data() + end, value);
        if (read.ec != std::errc() || read.ptr != line.data() + end || !std::isfinite(value))
            throw InputError(where + "'" + printable(line.substr(begin, end - begin), 40) +
                             "': expected a finite number");
        if (std::abs(value) > largest_number)
            throw InputError(where + "'" + printable(line.substr(begin, end - begin), 40) +
                             "': expected a number of a size up to " + shortest(largest_number));
        to.push_back(value);
        begin = line.find_first_not_of(separators, end);
    }
}

}  // namespace

Table read_table(const std::string& path, uint64_t max_bytes)
{
    const std::string name = path == "-" ? "standard input" : printable(path, 4096);
    std::istringstream lines(read_text(path, max_bytes, "table"));
    Table table;
    uint64_t number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        const size_t begin = line.find_first_not_of(separators);
        if (begin == std::string::npos || line[begin] == '#' || line[begin] == '!') continue;
        const std::string where = name + ": line " + std::to_string(number) + ": ";
        const size_t before = table.values.size();
        add_numbers(line, where, table.values);
        const size_t count = table.values.size() - before;
        if (table.rows++ == 0) table.columns = count;
        if (count != table.columns)
            throw InputError(where + std::to_string(count) + " numbers: expected " + std::to_string(table.columns) +
                             ", as in the first row");
    }
    if (table.rows == 0) throw InputError(name + ": holds no numbers: expected rows of numbers");
    return table;
}

}  // namespace vdbcloud
