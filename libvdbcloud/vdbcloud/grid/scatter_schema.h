#pragma once
// Grids and metadata of multiple scattering, beyond schema.h: the scaled medium and the light they belong to. The true medium stands
// beside it as of a density grid, and so does density_digest.

//
// Moments of collided radiance of degree 2 and more are vec3s grids (r g b) "sh_LM", M with m or p before it but for 0:
// sh_2m2, sh_2m1, sh_20, sh_2p1, sh_2p2, ...; real, orthonormal, without the Condon-Shortley sign, about the world's axes. phi is
// sqrt(4 pi) times degree 0, flux sqrt(4 pi / 3) times degree 1.
#include <string>

namespace vdbcloud::schema {

inline constexpr const char* moment_prefix = "sh_";
inline std::string moment_name(int l, int m)
{
    return moment_prefix + std::to_string(l) + (m < 0 ? "m" : m > 0 ? "p" : "") + std::to_string(m < 0 ? -m : m);
}

inline constexpr const char* degree = "vdbcloud:degree";      // double: of the expansion that collided light was scattered with

inline constexpr const char* delta_f = "vdbcloud:delta_f";    // double: share of scattered light taken as unscattered, 0: none
inline constexpr const char* scaled_g = "vdbcloud:scaled_g";  // double: mean cosine g' of the rest
inline constexpr const char* lit_by = "vdbcloud:lights";      // string: the lights that were scattered (lights_text)
inline constexpr const char* lit_sky = "vdbcloud:sky";        // vec3d: radiance of the sky that entered, straight down
inline constexpr const char* lit_sky_horizon = "vdbcloud:sky_horizon";  // vec3d: along the horizon; without it as lit_sky
inline constexpr const char* lit_sky_ground = "vdbcloud:sky_ground";    // vec3d: from below; without it as lit_sky
inline constexpr const char* lit_sky_haze = "vdbcloud:sky_haze";        // double: the horizon's band (scene/sky.h)
inline constexpr const char* lit_sky_up = "vdbcloud:sky_up";            // vec3d: unit

}  // namespace vdbcloud::schema
