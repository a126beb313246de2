#include "vdbcloud/grid/schema.h"

namespace vdbcloud::schema {

std::vector<std::string> aliases(const std::string& name)
{
    static const std::vector<std::vector<std::string>> families = {
        {density, "smoke", "soot", "voxel_fog_density"},
        {temperature, "heat"},
        {flame, "flames", "fire"},
        {velocity, "v", "velocity"},
        {colour, "color", "colour", "albedo"},
    };
    for (const auto& family : families)
        if (family.front() == name) return family;
    return {name};
}

}  // namespace vdbcloud::schema
