#pragma once
// Every grid and every key of metadata that the stages exchange, as a table: the one place that knows what a name
// means. docs/format.md is the same table for people, and tests/grid/registry_test.cc holds the two together.
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"

#include <string>
#include <vector>

namespace vdbcloud::schema {

/// Version of docs/format.md: grows when a reader of the former version would misread a file.
inline constexpr int format_version = 1;
inline constexpr const char* format = "vdbcloud:format";  // double, of the file: the version it was written in

// Grids that one stage alone knows.
inline constexpr const char* water = "qt";
inline constexpr const char* rain = "rain";
inline constexpr const char* dye = "dye";
inline constexpr const char* series_phi_prefix = "series_phi_";    // then the order
inline constexpr const char* series_flux_prefix = "series_flux_";  // the same
inline constexpr const char* series_raw_prefix = "series_I_";      // the same

// Metadata of series_phi_0: numbers as text, between blanks.
inline constexpr const char* series_albedo = "vdbcloud:series_albedo";  // rows of the table: albedos, rising
inline constexpr const char* series_table = "vdbcloud:series_table";    // coefficients of the basis, a row an albedo
inline constexpr const char* series_map = "vdbcloud:series_map";        // n x n, I_k = sum_j map[k n + j] basis_j
inline constexpr const char* series_scale = "vdbcloud:series_scale";    // vec3d: r, g, b are this times the sum

/// `channel` 0, 1, 2: flux_r, flux_g, flux_b.
inline std::string flux_name(int channel) { return std::string(flux_prefix) + "rgb"[channel]; }
inline std::string series_phi_name(size_t order) { return series_phi_prefix + std::to_string(order); }
inline std::string series_flux_name(size_t order) { return series_flux_prefix + std::to_string(order); }
inline std::string series_raw_name(size_t order) { return series_raw_prefix + std::to_string(order); }

enum class Role {
    Density,
    Temperature,
    Flame,
    Velocity,
    Colour,
    Emission,
    Transmittance,
    Fluence,
    Flux,
    Moment,
    SeriesFluence,
    SeriesFlux,
    SeriesOrder,
    Solid,
    Water,
    Rain,
    Dye
};

/// What follows the beginning of a name.
enum class Rest { Nothing, Light, Channel, Harmonic, Order };

/// One row of the table.
struct GridKind {
    Role role;
    const char* name;                  ///< whole, or how it begins
    Rest rest;                         ///< what follows
    const char* rest_text;             ///< the same for people: "LIGHT"; empty if nothing follows
    std::vector<const char*> aliases;  ///< names by which other programs call it, best first
    const char* type;                  ///< OpenVDB's value type; "float or vec3s" where both occur
    const char* unit;
    const char* grid_class;  ///< "fog volume", "level set", "staggered" or "unknown", as OpenVDB spells them
    const char* background;
    const char* stages;  ///< programs that write it
    /// Computed from a density by illuminate or p1solve, for a later stage that reads it in full precision: never
    /// stored as half, whatever flag it inherited.
    bool result;
    bool half;  ///< --half stores it as 16-bit floats
    bool kept;  ///< --keep none keeps it: a later stage needs it. Others are kept where this stage used them.
};

const std::vector<GridKind>& grid_kinds();

/// The row that a grid's name belongs to, aliases included, upper and lower case alike for these; null for a name that
/// no stage knows.
const GridKind* kind_of(const std::string& grid_name);

/// True if the name belongs to that role.
bool has_role(const std::string& grid_name, Role);

/// One key of metadata.
struct MetaKey {
    const char* key;    ///< whole, or how it begins
    const char* type;   ///< "string", "double" or "vec3d"
    const char* where;  ///< "file", or the grid that bears it
};

const std::vector<MetaKey>& meta_keys();

/// True of a key in the table.
bool is_known_key(const std::string& key);

}  // namespace vdbcloud::schema
