#pragma once
// Fields of cloud models in netCDF files as extinction.
#include "vdbcloud/exchange/cell_field.h"

#include <map>
#include <string>
#include <vector>

namespace vdbcloud {

/// What a user says of a file that the file does not say, or says in words that we do not know.
struct CloudFieldOptions {
    /// Names of variables by their role, of cloud_field_roles().
    std::map<std::string, std::string> variables;
    std::map<std::string, std::string> units;  ///< units of variables by their name; they replace the attribute
    Vec3d cell{0, 0, 0};                       ///< size of the cells of the grid [m]; 0: the file's
    double effective_radius = 0;               ///< [m] where the file has none; 0: 10 micrometres
    double air_density =
        0;  ///< [kg/m^3] where the file has none, in place of its pressure and temperature; 0: not given
};

/// "extinction", "water", "radius", "density", "pressure", "temperature", "theta", "x", "y", "z", "time".
const std::vector<std::string>& cloud_field_roles();

/// Extinction of one time, on equal cells.
struct CloudField {
    Cells cells;                                         ///< [m]
    std::vector<float> extinction;                       ///< [1/m], x fastest, finite and not below 0
    std::vector<std::string> said;                       ///< what was found, assumed and repaired, a sentence each
    double water = 0;                                    ///< mass of liquid water [kg]; 0 where the file has extinction
    double radius = 0;                                   ///< effective radius [m] where it is one for all cells; else 0
    bool used_radius = false, used_air_density = false;  ///< whether the options had an effect
};

/// Number of times that the water, or the extinction, has. Throws as read_cloud_field() does.
size_t cloud_field_times(const std::string& path, const CloudFieldOptions&);

/// The field at a time, counted from 0.
///
/// Extinction is 3 L / (2 rho_w r), L the mass of liquid water in a volume, rho_w = 1000 kg/m^3, r the effective radius
/// (large droplets: extinction efficiency 2). Water per mass of air is multiplied by the density of air: the file's,
/// or air_density, or p / (R_d T). Roles are found by CF standard_name and axis, then by common names; axes may fall.
/// Cells lie between CF bounds or midway between coordinates; unequal ones are resampled onto equal ones, and the water
/// of each column is kept. Negative and missing water counts as 0.
///
/// Throws IoError if the file cannot be read, else InputError with path and variable: damaged file, missing variable,
/// dimension without coordinate or role, missing or unsuitable unit. The file is read in a guarded process.
CloudField read_cloud_field(const std::string& path, const CloudFieldOptions&, size_t time);

}  // namespace vdbcloud
