#pragma once
// Names, units and metadata of the grids that the stages exchange.
//
// | grid                   | type  | unit, meaning                                              | background |
// |------------------------|-------|------------------------------------------------------------|------------|
// | density                | float | density in the source's unit; sigma_t = scale x density    | 0          |
// | medium_N               | float | density of the Nth of overlapping media                     | 0          |
// | temperature            | float | kelvin                                                     | 0          |
// | vel                    | vec3s | velocity [world unit/s]                                    | 0          |
// | Cd                     | vec3s | albedo tint per colour channel, 0..1                       | 1          |
// | Cd_N                   | vec3s | albedo tint of the Nth of overlapping media                | 1          |
// | emission               | vec3s | emitted radiance per length [radiance/world unit]          | 0          |
// | transmittance_<light>  | float, or vec3s where extinction is coloured; exp(-tau) to the light | 1 |
// | phi                    | vec3s, or float where channels share one; collided fluence, integral of L over the sphere | 0 |
// | flux, flux_<rgb>       | vec3s | collided flux, integral of s L, one spatial vector a colour | 0         |
// | sh_<lm>, sh_<lm>_<rgb> | float | moments of collided radiance, degree 2 and more (grid/scatter_schema.h) | 0 |
// | heating                | vec3s, or float where channels share one; absorbed power per volume | 0            |
// | ground_radiance        | vec3s | radiance of the ground upwards, at the layer where it lies | 0          |
// | environment            | vec3s | radiance from all directions, latitude (-y) by longitude (-x), a voxel a texel | 0 |
// | solid                  | float | level set of an opaque body, signed distance [world unit]  | +band      |
//
// Lengths are world units. Directions point along propagation, except `light_to`, which points towards the light.
// Names hold letters, digits and '_' only, so that every viewer lists them.
#include <string>
#include <vector>

namespace vdbcloud::schema {

// Grids.
inline constexpr const char* density = "density";
inline constexpr const char* medium_prefix = "medium_";  // followed by 2, 3, ...
inline constexpr const char* temperature = "temperature";
inline constexpr const char* flame = "flame";
inline constexpr const char* velocity = "vel";
inline constexpr const char* colour = "Cd";
inline constexpr const char* medium_colour_prefix = "Cd_";  // followed by 2, 3, ...
inline constexpr const char* emission = "emission";
inline constexpr const char* transmittance_prefix = "transmittance_";
inline constexpr const char* phi = "phi";
inline constexpr const char* flux = "flux";          // of all channels
inline constexpr const char* flux_prefix = "flux_";  // followed by r, g or b
inline constexpr const char* heating = "heating";
inline constexpr const char* ground_radiance = "ground_radiance";
inline constexpr const char* environment = "environment";
inline constexpr const char* solid = "solid";

// Metadata of the file.
inline constexpr const char* creator = "creator";                  // "TOOL VERSION"
inline constexpr const char* history = "history";                  // one command per line, oldest first
inline constexpr const char* up_axis = "up_axis";                  // "Y" or "Z"
inline constexpr const char* meters_per_unit = "meters_per_unit";  // double
inline constexpr const char* density_choice = "vdbcloud:density";  // --density of an earlier stage: NAME or NAME[k]
inline constexpr const char* media =
    "vdbcloud:media";  // double: overlapping media, density, medium_2, ...; absent: one

// Metadata of the density grid: the coefficients of the medium.
inline constexpr const char* sigma_t_per_density = "vdbcloud:sigma_t_per_density";  // vec3d [1/world unit]
inline constexpr const char* sigma_t_origin = "vdbcloud:sigma_t_origin";            // "given" or "automatic"
inline constexpr const char* albedo = "vdbcloud:albedo";                            // vec3d, 0..1
inline constexpr const char* g = "vdbcloud:g";                                      // double, -1..1
inline constexpr const char* phase = "vdbcloud:phase";  // "isotropic", "rayleigh", "henyey-greenstein"

// Metadata of a transmittance grid: its light, and the density from which it was computed.
inline constexpr const char* light_kind = "vdbcloud:light_kind";          // "directional", "point" or "spot"
inline constexpr const char* light_to = "vdbcloud:light_to";              // vec3d, unit, towards a directional light
inline constexpr const char* light_position = "vdbcloud:light_position";  // vec3d [world]
inline constexpr const char* light_irradiance = "vdbcloud:light_irradiance";  // vec3d; point: intensity [per sr]
inline constexpr const char* light_angular_diameter = "vdbcloud:light_angular_diameter";  // double [degrees]
inline constexpr const char* light_axis = "vdbcloud:light_axis";    // vec3d, unit, in which a spot shines
inline constexpr const char* light_cone = "vdbcloud:light_cone";    // double, a spot's cone from edge to edge [degrees]
inline constexpr const char* light_blend = "vdbcloud:light_blend";  // double, soft part of a spot's cone
inline constexpr const char* density_digest = "vdbcloud:density_digest";  // string: grid_digest() of that density

// Metadata of a solid: its shape and its material (scene/solid.h).
inline constexpr const char* solid_kind = "vdbcloud:solid_kind";        // "level set", "plane", "sphere" or "box"
inline constexpr const char* solid_place = "vdbcloud:solid_place";      // vec3d [world]: a point, middle, lowest corner
inline constexpr const char* solid_extent = "vdbcloud:solid_extent";    // vec3d: normal, radius, highest corner
inline constexpr const char* solid_finish = "vdbcloud:solid_finish";    // "diffuse", "mirror" or "glossy"
inline constexpr const char* solid_colour = "vdbcloud:solid_colour";    // vec3d, 0..1: reflectance
inline constexpr const char* solid_checker = "vdbcloud:solid_checker";  // vec3d, 0..1: of every second cube
inline constexpr const char* solid_checker_edge = "vdbcloud:solid_checker_edge";  // double [world unit]
inline constexpr const char* solid_roughness = "vdbcloud:solid_roughness";        // double, 0..1
// Of results: solids_digest() of the solids that stood in the light.
inline constexpr const char* solids = "vdbcloud:solids";

// Metadata of temperature, or of flame without temperature: T [K] = offset + scale x value.
inline constexpr const char* kelvin_scale = "vdbcloud:kelvin_scale";      // double [K]
inline constexpr const char* kelvin_offset = "vdbcloud:kelvin_offset";    // double [K]
inline constexpr const char* fire_intensity = "vdbcloud:fire_intensity";  // double: emission over that of a black body
// Metadata of flame: absorption that its luminous soot would have at flame 1.
inline constexpr const char* flame_absorption = "vdbcloud:flame_absorption";  // double [1/world unit]

/// The names that vdbcloud and other programs use for the grid `name`, preferred first, `name` included.
/// density|smoke|soot|voxel_fog_density, temperature|heat, flame|flames|fire, vel|v|velocity, Cd|color|colour|albedo.
std::vector<std::string> aliases(const std::string& name);

}  // namespace vdbcloud::schema
