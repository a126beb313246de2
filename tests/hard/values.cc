#include "hard/values.h"

#include <algorithm>
#include <limits>

namespace vdbcloud::test {

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

std::string name_of(const std::string& grid, const openvdb::Coord& c)
{
    return grid + " at " + std::to_string(c.x()) + "," + std::to_string(c.y()) + "," + std::to_string(c.z());
}

double largest(const Vec3d& v)
{
    double most = 0;
    for (int c = 0; c < 3; ++c)
        if (!(std::abs(v[c]) <= most)) most = std::abs(v[c]);
    return most;
}

bool failed(const Seen& seen, Verdict& verdict)
{
    if (seen.failure.empty()) return false;
    verdict.take(std::numeric_limits<double>::infinity(), seen.failure);
    return true;
}

std::string option(const std::string& words, const std::string& name, const std::string& otherwise)
{
    const Words all = split(words);
    const auto found = std::find(all.begin(), all.end(), name);
    return found == all.end() || found + 1 == all.end() ? otherwise : found[1];
}

Vec3d colour(const std::string& numbers)
{
    Vec3d v(std::stod(numbers));
    if (const size_t a = numbers.find(','); a != std::string::npos) {
        v[1] = std::stod(numbers.substr(a + 1));
        v[2] = std::stod(numbers.substr(numbers.find(',', a + 1) + 1));
    }
    return v;
}

void remove_option(std::string& words, const std::string& name)
{
    std::string left;
    const Words all = split(words);
    for (size_t k = 0; k < all.size(); ++k)
        if (all[k] == name)
            ++k;
        else
            left += all[k] + " ";
    words = left;
}

bool has_discs(const World& world)
{
    return std::any_of(world.lights.begin(), world.lights.end(), [](const auto& light) { return light.diameter > 0; });
}

bool has_lamps(const World& world)
{
    return std::any_of(world.lights.begin(), world.lights.end(), [](const auto& light) { return light.lamp; });
}

bool emits(const World& world)
{
    return std::any_of(world.bodies.begin(), world.bodies.end(),
                       [](const auto& body) { return body.find("emission=") != std::string::npos; });
}

double mean(const std::vector<float>& values)
{
    double sum = 0;
    for (const float value : values) sum += double(value);
    return values.empty() ? 0 : sum / double(values.size());
}

}  // namespace vdbcloud::test
