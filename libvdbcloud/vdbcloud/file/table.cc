#include "vdbcloud/file/table.h"

#include "vdbcloud/core/error.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
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
        to.push_back(value);
        begin = line.find_first_not_of(separators, end);
    }
}

/// All bytes of a file, or of standard input. Never holds more than max_bytes and a block.
std::string whole_text(const std::string& path, const std::string& name, uint64_t max_bytes)
{
    std::ifstream file;
    if (path != "-") file.open(path, std::ios::binary);
    std::istream& in = path == "-" ? std::cin : file;
    if (!in) throw IoError(name + ": cannot read it: " + std::strerror(errno));
    std::string text, block(1 << 16, ' ');
    while (in.read(block.data(), std::streamsize(block.size())) || in.gcount() > 0) {
        text.append(block, 0, size_t(in.gcount()));
        if (text.size() > max_bytes)
            throw IoError(name + ": has more than " + std::to_string(max_bytes) + " bytes: expected a smaller table");
    }
    if (in.bad()) throw IoError(name + ": cannot read it: " + std::strerror(errno));
    return text;
}

}  // namespace

Table read_table(const std::string& path, uint64_t max_bytes)
{
    const std::string name = path == "-" ? "standard input" : printable(path, 4096);
    std::istringstream lines(whole_text(path, name, max_bytes));
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
