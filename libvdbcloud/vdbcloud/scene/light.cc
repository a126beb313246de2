#include "vdbcloud/scene/light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr const char* directional = "directional";
constexpr const char* point = "point";

bool plain_name(const std::string& text)
{
    if (text.empty()) return false;
    for (const char c : text)
        if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9') && c != '_') return false;
    return true;
}

bool is_finite(const Vec3d& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

template<typename T>
[[noreturn]] void refuse(const Light& light, const char* what, const T& value, const char* expected)
{
    std::ostringstream sentence;
    sentence << "light '" << printable(light.name) << "': " << what << " " << value << ": expected " << expected;
    throw InputError(sentence.str());
}

/// Throws unless the light can be used; to_light becomes unit.
Light checked(Light light)
{
    if (!plain_name(light.name)) refuse(light, "name", printable(light.name), "letters, digits and '_'");
    if (light.kind == LightKind::Directional) {
        const double length = light.to_light.length();
        if (!(std::isfinite(length) && length > 0)) refuse(light, "direction", light.to_light, "a non-zero vector");
        light.to_light /= length;
    } else if (!is_finite(light.position)) {
        refuse(light, "position", light.position, "finite coordinates");
    }
    for (int c = 0; c < 3; ++c)
        if (!(light.irradiance[c] >= 0 && std::isfinite(light.irradiance[c])))
            refuse(light, "irradiance", light.irradiance, "finite numbers, 0 or above");
    if (!(light.angular_diameter >= 0 && light.angular_diameter <= 180))
        refuse(light, "angular diameter", light.angular_diameter, "degrees in [0, 180]");
    return light;
}

}  // namespace

std::string transmittance_name(const Light& light) { return schema::transmittance_prefix + light.name; }

void write_light(MetaMap& to, const Light& given)
{
    const Light light = checked(given);
    const bool is_point = light.kind == LightKind::Point;
    set_text(to, schema::light_kind, is_point ? point : directional);
    if (is_point)
        set_vector(to, schema::light_position, light.position);
    else
        set_vector(to, schema::light_to, light.to_light);
    set_vector(to, schema::light_irradiance, light.irradiance);
    set_number(to, schema::light_angular_diameter, light.angular_diameter);
}

std::optional<Light> read_light(const MetaMap& from, const std::string& grid_name)
{
    const std::string prefix = schema::transmittance_prefix;
    if (grid_name.rfind(prefix, 0) != 0 || !has_meta(from, schema::light_kind)) return std::nullopt;

    Light light;
    light.name = grid_name.substr(prefix.size());
    const std::string kind = get_text(from, schema::light_kind, "");
    if (kind != directional && kind != point)
        refuse(light, "kind", "'" + printable(kind) + "'", "directional or point");
    light.kind = kind == point ? LightKind::Point : LightKind::Directional;
    const char* where = light.kind == LightKind::Point ? schema::light_position : schema::light_to;
    if (!has_meta(from, where)) refuse(light, where, "is missing", "it beside the light's kind");
    light.position = get_vector(from, schema::light_position, light.position);
    light.to_light = get_vector(from, schema::light_to, light.to_light);
    light.irradiance = get_vector(from, schema::light_irradiance, light.irradiance);
    light.angular_diameter = get_number(from, schema::light_angular_diameter, light.angular_diameter);
    return checked(light);
}

std::vector<Light> lights_of(const GridFile& file)
{
    std::vector<Light> lights;
    for (const auto& grid : file.grids)
        if (const auto light = read_light(*grid, grid->getName())) lights.push_back(*light);
    return lights;
}

}  // namespace vdbcloud
