#include "vdbcloud/sim/large_scale.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

namespace vdbcloud::sim {

using Tables = std::vector<std::pair<std::string, std::string>>;
const Tables& forcing_tables();  // data/forcings, made by CMake

namespace {

using Column = std::vector<double> LargeScale::*;

struct Unit {
    const char* name;
    double factor;  ///< to SI
};
struct Known {
    const char* name;
    Column member;
    std::vector<Unit> units;
};

const std::vector<Known>& known_columns()
{
    constexpr double hour = 3600, day = 86400, gram = 1e-3;
    static const std::vector<Unit> wind{{"m/s", 1}, {"cm/s", 0.01}};
    static const std::vector<Known> list{
        {"z", &LargeScale::z, {{"m", 1}, {"km", 1000}}},
        {"w_ls", &LargeScale::w, wind},
        {"u_g", &LargeScale::u_g, wind},
        {"v_g", &LargeScale::v_g, wind},
        {"dtheta_l", &LargeScale::theta, {{"K/s", 1}, {"K/h", 1 / hour}, {"K/day", 1 / day}}},
        {"dq_t",
         &LargeScale::water,
         {{"1/s", 1}, {"kg/kg/s", 1}, {"g/kg/s", gram}, {"g/kg/h", gram / hour}, {"g/kg/day", gram / day}}}};
    return list;
}

/// What a heading asks for.
struct Heading {
    Column member;
    double factor;
};

/// Of "w_ls[cm/s]". Throws InputError that begins with `place`.
Heading heading_of(const std::string& place, const std::string& word)
{
    std::string names;
    for (const Known& column : known_columns()) {
        for (const Unit& unit : column.units)
            if (word == std::string(column.name) + "[" + unit.name + "]") return {column.member, unit.factor};
        names += (names.empty() ? "" : " ") + std::string(column.name) + "[";
        for (const Unit& unit : column.units)
            names += (&unit == &column.units.front() ? "" : "|") + std::string(unit.name);
        names += "]";
    }
    throw InputError(place + "'" + printable(word, 60) + "': expected headings of " + names);
}

std::vector<std::string> words_of(std::string line)
{
    line = line.substr(0, line.find('#'));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

std::optional<double> number_of(const std::string& word)
{
    std::istringstream in(word);
    double value = 0;
    if (!(in >> value) || !in.eof() || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// Fills gaps, which are NaN, on the lines between the values around them; beyond the outermost values with these.
void fill_gaps(const std::vector<double>& z, std::vector<double>& column)
{
    std::vector<double> at, value;
    for (size_t i = 0; i < z.size(); ++i)
        if (!std::isnan(column[i])) at.push_back(z[i]), value.push_back(column[i]);
    for (size_t i = 0; i < z.size(); ++i)
        if (std::isnan(column[i])) column[i] = interpolate(at, value, z[i]);
}

}  // namespace

LargeScale read_large_scale(const std::string& name, const std::string& text)
{
    LargeScale forcing;
    forcing.name = name;
    std::vector<Heading> headings;
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        const std::string place = printable(name) + ": line " + std::to_string(number) + ": ";
        const auto words = words_of(line);
        if (words.empty()) continue;
        if (headings.empty()) {
            for (const std::string& word : words) headings.push_back(heading_of(place, word));
            for (size_t a = 0; a < headings.size(); ++a)
                for (size_t b = 0; b < a; ++b)
                    if (headings[a].member == headings[b].member)
                        throw InputError(place + "'" + printable(words[a], 60) + "': expected each column once");
            if (headings[0].member != &LargeScale::z) throw InputError(place + "expected z as the first column");
            continue;
        }
        if (words.size() != headings.size())
            throw InputError(place + std::to_string(words.size()) + " values: expected " +
                             std::to_string(headings.size()));
        for (size_t c = 0; c < words.size(); ++c) {
            const auto value = words[c] == "-" && c > 0 ? std::optional(double(NAN)) : number_of(words[c]);
            if (!value) throw InputError(place + "'" + printable(words[c], 60) + "': expected a finite number, or -");
            (forcing.*headings[c].member).push_back(*value * headings[c].factor);
        }
        const size_t n = forcing.z.size();
        if (n > 1 && forcing.z[n - 1] <= forcing.z[n - 2]) throw InputError(place + "expected heights that increase");
    }
    if (forcing.z.empty() || headings.size() < 2)
        throw InputError(printable(name) + ": expected a table of z and one more column or more");
    for (const Heading& heading : headings) {
        auto& column = forcing.*heading.member;
        if (std::all_of(column.begin(), column.end(), [](double value) { return std::isnan(value); }))
            throw InputError(printable(name) + ": a column of gaps alone: expected one number or more in each column");
        fill_gaps(forcing.z, column);
    }
    return forcing;
}

LargeScale large_scale_named(const std::string& name)
{
    std::string names;
    for (const auto& [known, table] : forcing_tables()) {
        if (known == name) return read_large_scale(name, table);
        names += (names.empty() ? "" : ", ") + known;
    }
    throw InputError("forcing '" + printable(name) + "': expected a file, one of " + names + ", or none");
}

}  // namespace vdbcloud::sim
