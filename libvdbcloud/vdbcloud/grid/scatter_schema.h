#pragma once
// Grids and metadata of multiple scattering, beyond schema.h: the scaled medium and the light they belong to. The true
// medium stands beside it as of a density grid, and so does density_digest.

//
// Moments of collided radiance of degree 2 and more are float grids "sh_LM_C", M with m or p before it but for 0, C the
// channel: sh_2m2_r, sh_2m1_r, sh_20_r, sh_2p1_r, sh_2p2_r, ...; where the three channels are multiples of one solution
// there is one grid "sh_LM" for all, and its metadata says what each channel is of it (channel_scale). Real,
// orthonormal, without the Condon-Shortley sign, about the world's axes. phi is sqrt(4 pi) times degree 0, flux sqrt(4
// pi / 3) times degree 1.
#include <string>

namespace vdbcloud::schema {

inline constexpr const char* moment_prefix = "sh_";
/// `channel` 0, 1, 2: r, g, b; -1: of all.
inline std::string moment_name(int l, int m, int channel)
{
    const std::string name = moment_prefix + std::to_string(l) +
                             (m < 0   ? "m"
                              : m > 0 ? "p"
                                      : "") +
                             std::to_string(m < 0 ? -m : m);
    return channel < 0 ? name : name + '_' + "rgb"[channel];
}

inline constexpr const char* degree =
    "vdbcloud:degree";  // double: of the expansion that collided light was scattered with

inline constexpr const char* channel_scale = "vdbcloud:channel_scale";  // vec3d: r, g, b are this times the grid

inline constexpr const char* delta_f =
    "vdbcloud:delta_f";  // double: share of scattered light taken as unscattered, 0: none
// string: "1 m_1' ... m_L'", Legendre moments of the scaled phase function, L the degree
inline constexpr const char* scaled_moments = "vdbcloud:scaled_moments";
inline constexpr const char* lit_by = "vdbcloud:lights";  // string: the lights that were scattered (lights_text)
inline constexpr const char* lit_sky = "vdbcloud:sky";    // vec3d: radiance of the sky that entered, straight down
inline constexpr const char* lit_sky_horizon =
    "vdbcloud:sky_horizon";                                           // vec3d: along the horizon; without it as lit_sky
inline constexpr const char* lit_sky_ground = "vdbcloud:sky_ground";  // vec3d: from below; without it as lit_sky
inline constexpr const char* lit_sky_haze = "vdbcloud:sky_haze";      // double: the horizon's band (scene/sky.h)
inline constexpr const char* lit_sky_up = "vdbcloud:sky_up";          // vec3d: unit

}  // namespace vdbcloud::schema
