#pragma once
// Table of every grid and every metadata key that the stages exchange. Only this table defines the meaning of a name.
// docs/format.md documents the table; tests/grid/registry_test.cc checks that both agree.
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"

#include <limits>
#include <string>
#include <vector>

namespace vdbcloud::schema {

/// Version of docs/format.md. Increases when a reader of the previous version would misread a file.
inline constexpr int format_version = 2;
inline constexpr const char* format = "vdbcloud:format";  // double, file metadata: format version of this file

// Grids that a single stage uses.
inline constexpr const char* water = "qt";
inline constexpr const char* rain = "rain";
inline constexpr const char* dye = "dye";
inline constexpr const char* series_phi_prefix = "series_phi_";  // followed by the order
inline constexpr const char* series_raw_prefix = "series_I_";    // followed by the order

// Metadata of series_phi_0. The first three are numbers as text, separated by blanks.
inline constexpr const char* series_albedo = "vdbcloud:series_albedo";  // albedo of each table row, ascending
inline constexpr const char* series_table = "vdbcloud:series_table";    // coefficients of the basis, one row per albedo
inline constexpr const char* series_map = "vdbcloud:series_map";        // n x n, I_k = sum_j map[k n + j] basis_j
inline constexpr const char* series_scale = "vdbcloud:series_scale";    // vec3d: factors of the sum for r, g, b

// Metadata that cloudsim writes: of the density, of each grid, and of the file.
inline constexpr const char* air_density = "vdbcloud:air_density";            // double [kg/m^3]
inline constexpr const char* effective_radius = "vdbcloud:effective_radius";  // double [m]
inline constexpr const char* extinction_formula = "vdbcloud:extinction";      // text
inline constexpr const char* unit = "vdbcloud:unit";                          // text: unit of the values
inline constexpr const char* sim_parameters = "cloudsim:parameters";          // text
inline constexpr const char* sim_changes = "cloudsim:changes";                // text
inline constexpr const char* sim_pressure = "cloudsim:pressure";              // numbers as text [Pa], one per level
inline constexpr const char* sim_time = "cloudsim:time";                      // double [s]
inline constexpr const char* sim_steps = "cloudsim:steps";                    // double
inline constexpr const char* sim_w_max = "cloudsim:w_max";                    // double [m/s]
inline constexpr const char* sim_courant = "cloudsim:courant";                // double
inline constexpr const char* sim_water_drift = "cloudsim:water_drift";        // double
inline constexpr const char* sim_theta_drift = "cloudsim:theta_drift";        // double
inline constexpr const char* sim_divergence = "cloudsim:divergence";          // double [1/s]
inline constexpr const char* sim_cloud_base = "cloudsim:cloud_base";          // double [m]
inline constexpr const char* sim_cloud_top = "cloudsim:cloud_top";            // double [m]
inline constexpr const char* sim_cloud_max = "cloudsim:cloud_max";            // double [kg/kg]

/// `channel` 0, 1, 2: flux_r, flux_g, flux_b.
inline std::string flux_name(int channel) { return std::string(flux_prefix) + "rgb"[channel]; }
inline std::string series_phi_name(size_t order) { return series_phi_prefix + std::to_string(order); }
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
    SeriesOrder,
    Heating,
    GroundRadiance,
    Environment,
    Solid,
    Water,
    Rain,
    Dye
};

/// Variable part of a grid's name, after its prefix.
enum class Rest { Nothing, Light, Channel, Harmonic, Order };

/// One row of the table.
struct GridKind {
    Role role;
    const char* name;                  ///< whole name, or its prefix
    Rest rest;                         ///< kind of the variable part after the prefix
    const char* rest_text;             ///< placeholder for the variable part in documents: "LIGHT"; empty if none
    std::vector<const char*> aliases;  ///< names of this grid in other programs, preferred first
    const char* type;                  ///< OpenVDB value type; "float or vec3s" where both occur
    const char* unit;
    const char* grid_class;  ///< OpenVDB grid class: "fog volume", "level set", "staggered" or "unknown"
    const char* background;
    const char* stages;  ///< programs that write this grid
    /// Computed from a density by illuminate or p1solve. A later stage needs full precision, so the grid is never
    /// stored as half, even if it inherited the half flag.
    bool result;
    bool half;  ///< --half stores this grid as 16-bit floats
    /// --keep none keeps this grid, because a later stage needs it. Of other grids, --keep none keeps those that the
    /// stage used.
    bool kept;
};

const std::vector<GridKind>& grid_kinds();

/// The row for a grid's name or alias. Aliases match in upper and lower case. Null for a name that no stage uses.
const GridKind* kind_of(const std::string& grid_name);

/// True if kind_of(grid_name) has this role.
bool has_role(const std::string& grid_name, Role);

/// The numbers that a key may have. A vector has all components in the range.
struct Range {
    double least, greatest;  ///< finite numbers from `least` to `greatest`
    bool whole = false;      ///< whole numbers
    bool holds(double) const;
    /// "a finite number", "a whole number in [1, 100]", of a vector "three numbers in [0, 1]": for messages.
    std::string text(int components) const;
};
inline constexpr Range finite{-std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};

/// One key of metadata.
struct MetaKey {
    const char* key;       ///< whole key, or its prefix
    const char* type;      ///< "string", "double" or "vec3d"
    const char* where;     ///< "file", or the grid whose metadata contains the key
    Range range = finite;  ///< of a number
    /// vdbcloud's own: get_*() of grid/metadata.h refuse another type, or a number out of range. Keys without such a
    /// prefix are written by other programs too, with meanings of theirs: what does not fit is passed over.
    bool ours() const;
};

const std::vector<MetaKey>& meta_keys();

/// The row for a key; null for a key that no stage reads.
const MetaKey* meta_key(const std::string& key);

}  // namespace vdbcloud::schema
