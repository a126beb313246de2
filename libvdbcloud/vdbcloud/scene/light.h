#pragma once
// Lights as descriptions: what shines from where, and how that travels in a file.
#include "vdbcloud/core/fwd.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

struct GridFile;

enum class LightKind { Directional, Point };

/// One light. Directional: `irradiance` is E, perpendicular to the beam. Point: `irradiance` is the intensity
/// I [power per steradian], so that E = I / r^2 at distance r.
struct Light {
    std::string name = "sun";  ///< letters, digits, '_'; its grid is transmittance_<name>
    LightKind kind = LightKind::Directional;
    Vec3d to_light{0, 1, 0};    ///< unit, towards the light [world]; directional
    Vec3d position{0, 0, 0};    ///< [world]; point
    Vec3d irradiance{1, 1, 1};  ///< per colour channel
    double angular_diameter =
        0;  ///< of a directional light [degrees]; 0: a point at infinity. Its mean direction is to_light.
};

/// "transmittance_<name>".
std::string transmittance_name(const Light&);

/// Metadata of the light's transmittance grid (grid/schema.h). to_light is written as a unit vector.
/// Throws InputError naming the light and the value that cannot be: a name that is not plain, a direction
/// without length, an irradiance below 0 or not finite, an angular diameter outside [0, 180] degrees.
void write_light(MetaMap&, const Light&);

/// The light that a grid called `grid_name` with this metadata belongs to; nothing if it is no transmittance
/// grid of ours. Throws InputError as above, or where the light's kind is unknown or its direction or
/// position is missing.
std::optional<Light> read_light(const MetaMap&, const std::string& grid_name);

/// Every light described by the transmittance grids of a file, in file order.
std::vector<Light> lights_of(const GridFile&);

}  // namespace vdbcloud
