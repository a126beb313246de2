#pragma once
// Which variable of a netCDF file is what, and which dimension is which axis. Private to exchange/.
#include "vdbcloud/exchange/cloud_field.h"
#include "vdbcloud/exchange/netcdf_file.h"
#include "vdbcloud/exchange/units.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

/// The variable of a role: the one that the options name, else by standard_name, else by a common name in any case of
/// letters. Null if there is none; InputError if the options name one that is not there.
const NetcdfVariable* variable_of_role(const NetcdfFile&, const CloudFieldOptions&, const std::string& role);

/// The unit of a variable: the options', else its attribute. None if it has no attribute, or an empty one. InputError
/// for a text that is no unit.
std::optional<Unit> unit_of(const NetcdfVariable&, const CloudFieldOptions&);

/// The text of that unit, for messages.
std::string unit_text(const NetcdfVariable&, const CloudFieldOptions&);

/// Which dimensions are x, y, z and time, and what lies along the first three.
struct NetcdfAxes {
    std::array<int, 4> dimension{-1, -1, -1, -1};  ///< of x, y, z and time; -1: there is none
    std::array<bool, 3> falls{};                   ///< the file has the largest coordinate first
    Cells cells;                                   ///< edges that rise [m]

    size_t count(size_t axis) const { return cells.count(axis); }
};

/// The axes of a variable. `said` receives what was assumed.
NetcdfAxes axes_of(const NetcdfFile&, const CloudFieldOptions&, const NetcdfVariable&, std::vector<std::string>& said);

/// Values of a variable at a time on the cells of the axes, x fastest. Dimensions that the variable lacks repeat.
std::vector<float> values_on(const NetcdfFile&, const NetcdfAxes&, const NetcdfVariable&, size_t time);

}  // namespace vdbcloud
