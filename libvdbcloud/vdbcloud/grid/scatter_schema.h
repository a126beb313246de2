#pragma once
// Grids and metadata of multiple scattering, in addition to schema.h. The metadata describes the scaled medium and the
// light. The grids also have the metadata of the unscaled medium (keys of the density grid) and fingerprints of the
// grids behind the solution (sources.h).
//
// Moments of collided radiance of degree 2 and more are float grids "sh_LM_C": degree L, order M, channel C.
// A negative order is written m1, m2, ..., a positive order p1, p2, ...:
//   sh_2m2_r, sh_2m1_r, sh_20_r, sh_2p1_r, sh_2p2_r, ...
// Where the three channels are multiples of one solution, phi is a float grid, and one grid "flux" and one grid "sh_LM"
// serve all channels; their metadata channel_scale has the factor of each channel. The basis: real, orthonormal
// spherical harmonics without the Condon-Shortley sign, about the world axes. phi = sqrt(4 pi) x degree 0, flux =
// sqrt(4 pi / 3) x degree 1.
#include <string>

namespace vdbcloud::schema {

inline constexpr const char* moment_prefix = "sh_";
/// `channel` 0, 1, 2: r, g, b; -1: the grid that serves all channels.
inline std::string moment_name(int l, int m, int channel)
{
    const std::string name = moment_prefix + std::to_string(l) +
                             (m < 0   ? "m"
                              : m > 0 ? "p"
                                      : "") +
                             std::to_string(m < 0 ? -m : m);
    return channel < 0 ? name : name + '_' + "rgb"[channel];
}

// double: degree of the phase function's expansion for scattering of collided light
inline constexpr const char* degree = "vdbcloud:degree";
// vec3d: factors of the grid for r, g, b
inline constexpr const char* channel_scale = "vdbcloud:channel_scale";
// double: pictures shorten the flux, where it is longer, to this times phi; absent: they do not
inline constexpr const char* flux_limit = "vdbcloud:flux_limit";
// double: share of scattered light treated as unscattered; 0: none
inline constexpr const char* delta_f = "vdbcloud:delta_f";
// string: "1 m_1' ... m_L'", Legendre moments of the scaled phase function, L the degree
inline constexpr const char* scaled_moments = "vdbcloud:scaled_moments";
// string: coefficients of media that overlap and keep their phase functions (mixture_text); absent: one medium
inline constexpr const char* mixture = "vdbcloud:mixture";
// string: grid_digest() of the Cd and of the emission behind the solution; no_grid where there was none
inline constexpr const char* colour_digest = "vdbcloud:colour_digest";
inline constexpr const char* emission_digest = "vdbcloud:emission_digest";
inline constexpr const char* no_grid = "none";
// double: what bounds the error, followed by a name of accuracy_kinds() (accuracy.h)
inline constexpr const char* accuracy_prefix = "vdbcloud:accuracy_";
// string: parts of the light that the result does not have, separated by semicolons
inline constexpr const char* started_from = "vdbcloud:started_from";  // string: grid_digest() of the phi before
inline constexpr const char* left_out = "vdbcloud:left_out";
// string: index axes along which the medium repeats, of "xyz"; absent: none
inline constexpr const char* periodic = "vdbcloud:periodic";
// double: albedo of the ground beneath the medium; absent: no ground
inline constexpr const char* ground_albedo = "vdbcloud:ground_albedo";
// double, of the file: share of the scattered light that p1solve did not compute
inline constexpr const char* multiple_left_out = "vdbcloud:multiple_left_out";
// string: the lights of the solution (lights_text)
inline constexpr const char* lit_by = "vdbcloud:lights";
// string: kind of the sky (scene/sky.h); absent: gradient
inline constexpr const char* lit_sky_kind = "vdbcloud:sky_kind";
// double, vec3d, double: turbidity, unit vector to the sun, and radiance that stands for 1 kcd/m^2 of a sky by Preetham
inline constexpr const char* lit_sky_turbidity = "vdbcloud:sky_turbidity";
inline constexpr const char* lit_sky_sun = "vdbcloud:sky_sun";
inline constexpr const char* lit_sky_scale = "vdbcloud:sky_scale";
// string, double, double: fingerprint of the texels of an environment (scene/panorama.h), degrees that it is turned by
// (lit_sky_scale: what it is multiplied with), and 1 if its suns are part of it
inline constexpr const char* lit_sky_texels = "vdbcloud:sky_texels";
inline constexpr const char* lit_sky_turn = "vdbcloud:sky_turn";
inline constexpr const char* lit_sky_suns = "vdbcloud:sky_suns";
// vec3d: incident sky radiance from the zenith
inline constexpr const char* lit_sky = "vdbcloud:sky";
// vec3d: incident sky radiance from the horizon; absent: lit_sky
inline constexpr const char* lit_sky_horizon = "vdbcloud:sky_horizon";
// vec3d: incident radiance from below; absent: lit_sky
inline constexpr const char* lit_sky_ground = "vdbcloud:sky_ground";
// double: band of haze at the horizon (scene/sky.h)
inline constexpr const char* lit_sky_haze = "vdbcloud:sky_haze";
// vec3d: unit vector to the zenith
inline constexpr const char* lit_sky_up = "vdbcloud:sky_up";

}  // namespace vdbcloud::schema
