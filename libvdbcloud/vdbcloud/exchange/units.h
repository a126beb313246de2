#pragma once
// Units as attributes of files write them: "kg m-3", "g/kg", "um", "10^-6 m". Private to exchange/.
#include <optional>
#include <string>

namespace vdbcloud {

/// A unit as a multiple of kg^mass m^length s^time K^temperature.
struct Unit {
    double factor = 1;
    int mass = 0, length = 0, time = 0, temperature = 0;

    bool same_kind(const Unit& other) const
    {
        return mass == other.mass && length == other.length && time == other.time && temperature == other.temperature;
    }
};

/// Products of kg g mg ug, m km cm mm um nm, s, Pa hPa mbar, K and numbers, with powers as m-3, m^-3 or m**-3, and /
/// before a divisor. None for other text, and for an empty one.
std::optional<Unit> parse_unit(const std::string& text);

}  // namespace vdbcloud
