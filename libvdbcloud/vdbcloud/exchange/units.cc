#include "vdbcloud/exchange/units.h"

#include <charconv>
#include <cmath>
#include <map>

namespace vdbcloud {

namespace {

const std::map<std::string, Unit>& known_units()
{
    static const std::map<std::string, Unit> all = {
        {"kg", {1, 1}},
        {"g", {1e-3, 1}},
        {"mg", {1e-6, 1}},
        {"ug", {1e-9, 1}},
        {"m", {1, 0, 1}},
        {"meter", {1, 0, 1}},
        {"meters", {1, 0, 1}},
        {"metre", {1, 0, 1}},
        {"metres", {1, 0, 1}},
        {"km", {1e3, 0, 1}},
        {"kilometer", {1e3, 0, 1}},
        {"kilometers", {1e3, 0, 1}},
        {"kilometre", {1e3, 0, 1}},
        {"kilometres", {1e3, 0, 1}},
        {"cm", {1e-2, 0, 1}},
        {"mm", {1e-3, 0, 1}},
        {"um", {1e-6, 0, 1}},
        {"\xC2\xB5m", {1e-6, 0, 1}},  // micro sign
        {"\xCE\xBCm", {1e-6, 0, 1}},  // Greek mu
        {"micron", {1e-6, 0, 1}},
        {"microns", {1e-6, 0, 1}},
        {"micrometer", {1e-6, 0, 1}},
        {"micrometers", {1e-6, 0, 1}},
        {"micrometre", {1e-6, 0, 1}},
        {"micrometres", {1e-6, 0, 1}},
        {"nm", {1e-9, 0, 1}},
        {"s", {1, 0, 0, 1}},
        {"Pa", {1, 1, -1, -2}},
        {"hPa", {1e2, 1, -1, -2}},
        {"kPa", {1e3, 1, -1, -2}},
        {"mbar", {1e2, 1, -1, -2}},
        {"mb", {1e2, 1, -1, -2}},
        {"millibar", {1e2, 1, -1, -2}},
        {"bar", {1e5, 1, -1, -2}},
        {"K", {1, 0, 0, 0, 1}},
        {"kelvin", {1, 0, 0, 0, 1}},
        {"Kelvin", {1, 0, 0, 0, 1}},
        {"none", {}},
        {"dimensionless", {}},
    };
    return all;
}

Unit power(const Unit& unit, int exponent)
{
    return {std::pow(unit.factor, exponent), unit.mass * exponent, unit.length * exponent, unit.time * exponent,
            unit.temperature * exponent};
}

void multiply(Unit& by, const Unit& unit)
{
    by = {by.factor * unit.factor, by.mass + unit.mass, by.length + unit.length, by.time + unit.time,
          by.temperature + unit.temperature};
}

/// A whole number that is all of `text`.
std::optional<int> whole(const std::string& text)
{
    int value = 0;
    const char* const first = text.data() + (!text.empty() && text[0] == '+');
    const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || std::abs(value) > 12) return std::nullopt;
    return value;
}

/// A word as "m-3", "m^-3", "m**-3", "1e-6", "10^-6".
std::optional<Unit> parse_word(const std::string& word)
{
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const bool is_number = error == std::errc() && number > 0;
    size_t base = 0;
    if (is_number)
        base = size_t(end - word.data());
    else
        while (base < word.size() && std::string("0123456789+-^*").find(word[base]) == std::string::npos) ++base;
    const auto known = known_units().find(word.substr(0, base));
    if (!is_number && known == known_units().end()) return std::nullopt;
    const Unit unit = is_number ? Unit{number} : known->second;
    std::string exponent = word.substr(base);
    if (exponent.empty()) return unit;
    if (exponent.rfind("**", 0) == 0)
        exponent.erase(0, 2);
    else if (exponent[0] == '^')
        exponent.erase(0, 1);
    else if (is_number)
        return std::nullopt;
    const auto value = whole(exponent);
    return value ? std::optional(power(unit, *value)) : std::nullopt;
}

}  // namespace

std::optional<Unit> parse_unit(const std::string& text)
{
    Unit all;
    bool divide = false, any = false;
    for (size_t at = 0; at < text.size();) {
        const char c = text[at];
        const bool star = c == '*' && !(at + 1 < text.size() && text[at + 1] == '*');
        if (c == ' ' || c == '\t' || c == '.' || star || c == '/') {
            divide = c == '/' || (divide && c == ' ');
            ++at;
            continue;
        }
        size_t end = at;
        while (end < text.size() && std::string(" \t/").find(text[end]) == std::string::npos) {
            const bool power = text.compare(end, 2, "**") == 0;
            const bool decimal = text[end] == '.' && end > at && text[end - 1] >= '0' && text[end - 1] <= '9';
            if (!power && !decimal && (text[end] == '*' || text[end] == '.')) break;
            end += power ? 2 : 1;
        }
        const auto unit = parse_word(text.substr(at, end - at));
        if (!unit) return std::nullopt;
        multiply(all, divide ? power(*unit, -1) : *unit);
        divide = false;
        any = true;
        at = end;
    }
    return any ? std::optional(all) : std::nullopt;
}

}  // namespace vdbcloud
