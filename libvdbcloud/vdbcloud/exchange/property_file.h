#pragma once
// Property files of SHDOM (Evans 1998): extinction, albedo, phase function and temperature at grid points.
#include "vdbcloud/exchange/cell_field.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// The medium of a property file on equal cells, in the file's unit of length, which SHDOM's own files have as km.
struct PropertyField {
    Cells cells;
    std::vector<float> extinction;   ///< [1/unit]
    std::vector<float> albedo;       ///< 0 to 1; 0 where there is no extinction
    std::vector<float> temperature;  ///< [K]; 0: the file has none there
    double g = 0;                    ///< mean cosine, weighted with scattering: first Legendre coefficient / 3
    std::vector<std::string> said;   ///< a sentence each
};

/// Reads the tabulated-phase-function format ("T"): the grid, the phase functions, and for each point ix iy iz,
/// temperature, extinction, albedo, number of the phase function. Points are the middles of cells. Levels of unequal
/// distance are resampled onto equal cells of size `cell` (0: the smallest distance), which keeps the optical depth of
/// each column; the albedo is then the mean weighted with extinction. Throws IoError if the file cannot be read, else
/// InputError with path and place.
PropertyField read_property_file(const std::string& path, const Vec3d& cell);

}  // namespace vdbcloud
