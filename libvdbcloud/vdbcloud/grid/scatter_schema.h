#pragma once
// Metadata of phi and flux, beyond schema.h: the scaled medium and the light they belong to. The true medium stands
// beside it as of a density grid, and so does density_digest.

namespace vdbcloud::schema {

inline constexpr const char* delta_f = "vdbcloud:delta_f";    // double: share of scattered light taken as unscattered, 0: none
inline constexpr const char* scaled_g = "vdbcloud:scaled_g";  // double: mean cosine g' of the rest
inline constexpr const char* lit_by = "vdbcloud:lights";      // string: the lights that were scattered (lights_text)
inline constexpr const char* lit_sky = "vdbcloud:sky";        // vec3d: radiance of the sky that entered

}  // namespace vdbcloud::schema
