#include "vdbcloud/exchange/particles.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

std::string plain(const std::string& name)
{
    std::string all;
    for (const char c : name)
        if (c >= 'A' && c <= 'Z')
            all += char(c - 'A' + 'a');
        else if (c != '"' && c != '\'' && c != ' ')
            all += c;
    return all;
}

int find(const std::vector<std::string>& names, const std::string& name)
{
    for (size_t k = 0; k < names.size(); ++k)
        if (plain(names[k]) == name) return int(k);
    return -1;
}

/// The column of component k of a vector.
int component(const std::vector<std::string>& names, const std::string& base, size_t k)
{
    const std::string letter(1, "xyz"[k]), digit(1, char('0' + k));
    for (const std::string& name : {base + letter, base + "." + letter, base + "_" + letter, base + ":" + digit,
                                    base + "[" + digit + "]", base + "_" + digit, base + "." + digit})
        if (const int column = find(names, name); column >= 0) return column;
    return -1;
}

struct Role {
    std::string name;
    size_t first, count;  // columns of particle_columns()
    std::vector<std::string> common;
};

const std::vector<Role>& roles()
{
    static const std::vector<Role> all = {
        {"position", 0, 3, {"", "p", "pos", "position", "points", "point"}},
        {"radius", 3, 1, {"radius", "pscale", "rad"}},
        {"mass", 4, 1, {"mass", "m"}},
        {"density", 5, 1, {"density", "rho"}},
        {"temperature", 6, 1, {"temperature", "temp"}},
        {"velocity", 7, 3, {"v", "vel", "velocity"}},
    };
    return all;
}

/// The columns of a role under a name; the first is -1 if any is missing.
std::array<int, 3> columns_of(const std::vector<std::string>& names, const Role& role, const std::string& name)
{
    std::array<int, 3> columns{-1, -1, -1};
    for (size_t k = 0; k < role.count; ++k) {
        columns[k] = role.count == 1 ? find(names, plain(name)) : component(names, plain(name), k);
        if (columns[k] < 0) return {-1, -1, -1};
    }
    return columns;
}

std::string listed(const std::vector<std::string>& names)
{
    std::string all;
    for (const std::string& name : names)
        if (all.size() < 200) all += (all.empty() ? "" : ", ") + printable(name, 40);
    return all;
}

}  // namespace

const std::vector<std::string>& particle_roles()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Role& role : roles()) all.push_back(role.name);
        return all;
    }();
    return names;
}

std::array<int, 10> particle_columns(const std::vector<std::string>& names, const ParticleNames& chosen)
{
    std::array<int, 10> columns{};
    columns.fill(-1);
    for (const Role& role : roles()) {
        const auto named = chosen.find(role.name);
        std::array<int, 3> found{-1, -1, -1};
        if (named != chosen.end())
            found = columns_of(names, role, named->second);
        else
            for (size_t k = 0; k < role.common.size() && found[0] < 0; ++k)
                found = columns_of(names, role, role.common[k]);
        if (found[0] < 0 && (named != chosen.end() || role.first == 0))
            throw InputError("no columns of the " + role.name +
                             (named == chosen.end() ? " x, y, z" : " '" + printable(named->second, 40) + "'") +
                             ": there are " + listed(names) + "; name them with --variable " + role.name + "=NAME");
        std::copy(found.begin(), found.begin() + std::ptrdiff_t(role.count),
                  columns.begin() + std::ptrdiff_t(role.first));
    }
    return columns;
}

void add_particle(Particles& all, const std::array<int, 10>& columns, const std::array<double, 10>& values,
                  const std::function<std::string()>& where)
{
    constexpr double farthest = 1e9, largest = 1e30;
    const auto refuse_value = [&](const char* what, double value, const char* expected) {
        throw InputError(where() + what + " " + shortest(value) + ": expected " + expected);
    };
    for (size_t k = 0; k < 3; ++k)
        if (!(std::abs(values[k]) <= farthest)) refuse_value("position", values[k], "numbers within 1e9");
    all.position.emplace_back(values[0], values[1], values[2]);
    const auto keep = [&](size_t column, std::vector<float>& to, const char* what) {
        if (columns[column] < 0) return;
        if (!(values[column] >= 0 && values[column] <= largest)) refuse_value(what, values[column], "0 to 1e30");
        to.push_back(float(values[column]));
    };
    keep(3, all.radius, "radius");
    keep(4, all.mass, "mass");
    keep(5, all.density, "density");
    keep(6, all.temperature, "temperature");
    if (columns[7] < 0) return;
    for (size_t k = 7; k < 10; ++k)
        if (!(std::abs(values[k]) <= largest)) refuse_value("velocity", values[k], "numbers within 1e30");
    all.velocity.emplace_back(float(values[7]), float(values[8]), float(values[9]));
}

}  // namespace vdbcloud
