#include "vdbcloud/grid/registry.h"

#include "vdbcloud/core/number_range.h"
#include "vdbcloud/core/shortest.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::schema {

namespace {

constexpr bool yes = true, no = false;

std::string lower(std::string text)
{
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return text;
}

bool digits(const std::string& text)
{
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// True for "20", "2m1", "2p1" and the like, optionally followed by "_r", "_g" or "_b".
bool harmonic(std::string text)
{
    if (text.size() > 2 && text[text.size() - 2] == '_' && std::string("rgb").find(text.back()) != std::string::npos)
        text.resize(text.size() - 2);
    const size_t sign = text.find_first_of("mp");
    if (sign == std::string::npos) return text.size() >= 2 && digits(text);
    return digits(text.substr(0, sign)) && digits(text.substr(sign + 1));
}

bool follows(const std::string& rest, Rest kind)
{
    switch (kind) {
    case Rest::Nothing: return rest.empty();
    case Rest::Light: return !rest.empty();
    case Rest::Channel: return rest == "r" || rest == "g" || rest == "b";
    case Rest::Harmonic: return harmonic(rest);
    case Rest::Order: return digits(rest);
    }
    return false;
}

bool matches(const GridKind& kind, const std::string& name)
{
    const std::string begin = kind.name;
    if (name.compare(0, begin.size(), begin) == 0 && follows(name.substr(begin.size()), kind.rest)) return true;
    if (kind.rest != Rest::Nothing) return false;
    return lower(name) == lower(begin) || std::any_of(kind.aliases.begin(), kind.aliases.end(),
                                                      [&](const char* alias) { return lower(name) == lower(alias); });
}

}  // namespace

// clang-format off
const std::vector<GridKind>& grid_kinds()
{
    static const std::vector<GridKind> table = {
        // role, name, rest, aliases, type, unit, class, background, stages, result, half, kept
        {Role::Density, density, Rest::Nothing, "", {"smoke", "soot", "voxel_fog_density"},
         "float", "any; sigma_t = vdbcloud:sigma_t_per_density x density", "fog volume", "0", "fractalgen, cloudsim, vdbimport", no, yes, yes},
        {Role::Density, medium_prefix, Rest::Order, "N", {},
         "float", "as density", "fog volume", "0", "p1solve", no, yes, yes},
        {Role::Temperature, temperature, Rest::Nothing, "", {"heat"},
         "float", "K", "fog volume", "0", "cloudsim, vdbimport, other programs", no, no, no},
        {Role::Flame, flame, Rest::Nothing, "", {"flames", "fire"},
         "float", "any; of cloudsim K/s", "fog volume", "0", "cloudsim, other programs", no, no, no},
        {Role::Velocity, velocity, Rest::Nothing, "", {"v", "velocity"},
         "vec3s", "world unit/s", "staggered", "0 0 0", "cloudsim, vdbimport", no, no, no},
        {Role::Colour, colour, Rest::Nothing, "", {"color", "colour", "albedo"},
         "vec3s", "1 (0 to 1)", "unknown", "1 1 1", "vdbimport, other programs", no, yes, no},
        {Role::Colour, medium_colour_prefix, Rest::Order, "N", {},
         "vec3s", "1 (0 to 1)", "unknown", "1 1 1", "p1solve", no, yes, no},
        {Role::Emission, emission, Rest::Nothing, "", {},
         "vec3s", "radiance/world unit", "unknown", "0 0 0", "vdbimport, other programs", no, no, no},
        {Role::Transmittance, transmittance_prefix, Rest::Light, "LIGHT", {},
         "float or vec3s", "1 (0 to 1)", "unknown", "1", "illuminate, p1solve", yes, no, yes},
        {Role::Fluence, phi, Rest::Nothing, "", {},
         "float or vec3s", "radiance x sr", "unknown", "0", "p1solve", yes, no, yes},
        {Role::Flux, flux, Rest::Nothing, "", {},
         "vec3s", "radiance x sr", "unknown", "0 0 0", "p1solve", yes, no, yes},
        {Role::Flux, flux_prefix, Rest::Channel, "C", {},
         "vec3s", "radiance x sr", "unknown", "0 0 0", "p1solve", yes, no, yes},
        {Role::Moment, moment_prefix, Rest::Harmonic, "LM_C", {},
         "float", "radiance x sr", "unknown", "0", "p1solve", no, yes, yes},
        {Role::SeriesFluence, series_phi_prefix, Rest::Order, "K", {},
         "float", "1", "unknown", "0", "p1solve", yes, no, yes},
        {Role::SeriesOrder, series_raw_prefix, Rest::Order, "K", {},
         "float", "radiance x sr", "unknown", "0", "p1solve", yes, no, yes},
        {Role::Heating, heating, Rest::Nothing, "", {},
         "float or vec3s", "radiance x sr/world unit", "unknown", "0", "p1solve", yes, no, no},
        {Role::GroundRadiance, ground_radiance, Rest::Nothing, "", {},
         "vec3s", "radiance", "unknown", "far ground", "p1solve", yes, no, yes},
        {Role::Environment, environment, Rest::Nothing, "", {},
         "vec3s", "radiance", "unknown", "0 0 0", "p1solve", no, no, yes},
        {Role::Solid, solid, Rest::Nothing, "", {},
         "float", "world unit", "level set", "band", "fractalgen, illuminate, p1solve", no, no, yes},
        {Role::Solid, solid, Rest::Order, "N", {},
         "float", "world unit", "level set", "band", "illuminate, p1solve", no, no, yes},
        {Role::Water, water, Rest::Nothing, "", {},
         "float", "kg/kg", "fog volume", "0", "cloudsim", no, no, no},
        {Role::Rain, rain, Rest::Nothing, "", {},
         "float", "kg/kg", "fog volume", "0", "cloudsim", no, no, no},
        {Role::Dye, dye, Rest::Nothing, "", {},
         "float", "1", "fog volume", "0", "cloudsim", no, no, no},
    };
    return table;
}

const std::vector<MetaKey>& meta_keys()
{
    constexpr Range nonnegative{0, largest_number}, share{0, 1}, positive{1e-30, largest_number};
    constexpr Range coordinate{-largest_number, largest_number};
    static const std::vector<MetaKey> table = {
        {creator, "string", "file"},
        {history, "string", "file"},
        {format, "double", "file"},
        {up_axis, "string", "file"},
        {meters_per_unit, "double", "file", positive},
        {density_choice, "string", "file"},
        {media, "double", "file", {2, 100, yes}},
        {multiple_left_out, "double", "file", share},
        {sim_parameters, "string", "file"},
        {sim_changes, "string", "file"},
        {sim_pressure, "string", "file"},
        {sim_time, "double", "file"},
        {sim_steps, "double", "file"},
        {sim_w_max, "double", "file"},
        {sim_courant, "double", "file"},
        {sim_water_drift, "double", "file"},
        {sim_theta_drift, "double", "file"},
        {sim_divergence, "double", "file"},
        {sim_cloud_base, "double", "file"},
        {sim_cloud_top, "double", "file"},
        {sim_cloud_max, "double", "file"},
        {sigma_t_per_density, "vec3d", "density", nonnegative},
        {sigma_t_origin, "string", "density"},
        {albedo, "vec3d", "density", share},
        {g, "double", "density"},
        {"vdbcloud:g1", "double", "density"},
        {"vdbcloud:g2", "double", "density"},
        {"vdbcloud:g1_weight", "double", "density"},
        {"vdbcloud:droplet_diameter", "double", "density"},
        {phase, "string", "density"},
        {air_density, "double", "density"},
        {effective_radius, "double", "density"},
        {extinction_formula, "string", "density"},
        {unit, "string", "grids of cloudsim; temperature"},
        {light_kind, "string", "transmittance_LIGHT"},
        {light_to, "vec3d", "transmittance_LIGHT", coordinate},
        {light_position, "vec3d", "transmittance_LIGHT", coordinate},
        {light_irradiance, "vec3d", "transmittance_LIGHT"},
        {light_angular_diameter, "double", "transmittance_LIGHT"},
        {light_axis, "vec3d", "transmittance_LIGHT", coordinate},
        {light_cone, "double", "transmittance_LIGHT"},
        {light_blend, "double", "transmittance_LIGHT", share},
        {density_digest, "string", "transmittance_LIGHT, phi, flux_C, sh_LM_C, series_phi_K"},
        {colour_digest, "string", "phi"},
        {emission_digest, "string", "phi"},
        {delta_f, "double", "phi", {0, 1 - 0x1p-53}},
        {scaled_moments, "string", "phi"},
        {mixture, "string", "transmittance_LIGHT, phi"},
        {lit_by, "string", "phi"},
        {lit_sky_kind, "string", "phi"},
        {lit_sky_turbidity, "double", "phi", nonnegative},
        {lit_sky_sun, "vec3d", "phi", coordinate},
        {lit_sky_scale, "double", "phi", nonnegative},
        {lit_sky_texels, "string", "phi"},
        {lit_sky_turn, "double", "phi", coordinate},
        {lit_sky_suns, "double", "phi", share},
        {lit_sky, "vec3d", "phi", nonnegative},
        {lit_sky_horizon, "vec3d", "phi", nonnegative},
        {lit_sky_ground, "vec3d", "phi", nonnegative},
        {lit_sky_haze, "double", "phi", nonnegative},
        {lit_sky_up, "vec3d", "phi", coordinate},
        {degree, "double", "phi", {1, 100, yes}},
        {channel_scale, "vec3d", "phi", nonnegative},
        {flux_limit, "double", "phi", share},
        {accuracy_prefix, "double", "transmittance_LIGHT, phi, series_phi_0"},
        {left_out, "string", "phi"},
        {started_from, "string", "phi"},
        {periodic, "string", "transmittance_LIGHT, phi"},
        {ground_albedo, "double", "phi", share},
        {solid_kind, "string", "solid"},
        {solid_place, "vec3d", "solid", coordinate},
        {solid_extent, "vec3d", "solid", coordinate},
        {solid_finish, "string", "solid"},
        {solid_colour, "vec3d", "solid", share},
        {solid_checker, "vec3d", "solid", share},
        {solid_checker_edge, "double", "solid", positive},
        {solid_roughness, "double", "solid", share},
        {solids, "string", "transmittance_LIGHT, phi"},
        {kelvin_scale, "double", "temperature, flame", coordinate},
        {kelvin_offset, "double", "temperature, flame", coordinate},
        {fire_intensity, "double", "temperature, flame", nonnegative},
        {flame_absorption, "double", "flame", nonnegative},
        {series_albedo, "string", "series_phi_0"},
        {series_table, "string", "series_phi_0"},
        {series_map, "string", "series_phi_0"},
        {series_scale, "vec3d", "series_phi_0", nonnegative},
    };
    return table;
}
// clang-format on

const GridKind* kind_of(const std::string& grid_name)
{
    for (const GridKind& kind : grid_kinds())
        if (matches(kind, grid_name)) return &kind;
    return nullptr;
}

bool has_role(const std::string& grid_name, Role role)
{
    const GridKind* kind = kind_of(grid_name);
    return kind && kind->role == role;
}

bool Range::holds(double x) const { return x >= least && x <= greatest && (!whole || x == std::floor(x)); }

std::string Range::text(int components) const
{
    const bool one = components == 1, bounded = least > finite.least || greatest < finite.greatest;
    std::string text = one ? "a " : "three ";
    text += whole ? "whole " : bounded ? "" : "finite ";
    text += one ? "number" : "numbers";
    return bounded ? text + " in [" + shortest(least) + ", " + shortest(greatest) + "]" : text;
}

bool MetaKey::ours() const
{
    const std::string name = key;
    return name.rfind("vdbcloud:", 0) == 0 || name.rfind("cloudsim:", 0) == 0;
}

const MetaKey* meta_key(const std::string& key)
{
    for (const MetaKey& known : meta_keys())
        if (key == known.key || (known.key == accuracy_prefix && key.rfind(accuracy_prefix, 0) == 0)) return &known;
    return nullptr;
}

std::vector<std::string> aliases(const std::string& name)
{
    std::vector<std::string> all{name};
    for (const GridKind& kind : grid_kinds())
        if (name == kind.name) all.insert(all.end(), kind.aliases.begin(), kind.aliases.end());
    return all;
}

}  // namespace vdbcloud::schema
