#include "vdbcloud/exchange/netcdf_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/exchange/netcdf_extent.h"

#include <netcdf.h>

#include <cmath>
#include <filesystem>
#include <limits>

namespace vdbcloud {

namespace {

void require(int status, const std::string& what)
{
    if (status != NC_NOERR) throw InputError(what + ": " + ::nc_strerror(status));
}

constexpr size_t longest_text = 1 << 16;

/// The attributes of a variable that are text, in either of the forms that netCDF has.
std::map<std::string, std::string> texts_of(int file, int variable, int attributes)
{
    std::map<std::string, std::string> all;
    for (int k = 0; k < attributes; ++k) {
        char name[NC_MAX_NAME + 1] = {};
        nc_type type = 0;
        size_t length = 0;
        require(::nc_inq_attname(file, variable, k, name), "attribute");
        require(::nc_inq_att(file, variable, name, &type, &length), name);
        if (type == NC_CHAR && length < longest_text) {
            std::string text(length, '\0');
            require(::nc_get_att_text(file, variable, name, text.data()), name);
            all[name] = text.substr(0, text.find('\0'));
        } else if (type == NC_STRING && length == 1) {
            char* text = nullptr;
            require(::nc_get_att_string(file, variable, name, &text), name);
            if (text) all[name] = std::string(text).substr(0, longest_text);
            ::nc_free_string(1, &text);
        }
    }
    return all;
}

NetcdfVariable variable_of(int file, int id)
{
    NetcdfVariable variable;
    variable.id = id;
    char name[NC_MAX_NAME + 1] = {};
    int count = 0, attributes = 0;
    nc_type type = 0;
    require(::nc_inq_var(file, id, name, &type, &count, nullptr, &attributes), "variable");
    variable.name = name;
    variable.dimensions.resize(size_t(count));
    if (count > 0) require(::nc_inq_vardimid(file, id, variable.dimensions.data()), name);
    variable.text = texts_of(file, id, attributes);
    return variable;
}

}  // namespace

std::string NetcdfVariable::attribute(const std::string& key) const
{
    const auto found = text.find(key);
    return found == text.end() ? std::string() : found->second;
}

NetcdfFile::NetcdfFile(const std::string& path)
{
    require(::nc_open(path.c_str(), NC_NOWRITE, &id_), "not a netCDF file, or damaged");
    if (const uint64_t least = classic_extent(id_), there = std::filesystem::file_size(path); there < least)
        throw InputError("damaged netCDF file: ends at " + std::to_string(there) + " bytes, expected " +
                         std::to_string(least) + " or more");
    int dimensions = 0, variables = 0;
    require(::nc_inq(id_, &dimensions, &variables, nullptr, nullptr), "header");
    for (int k = 0; k < dimensions; ++k) {
        char name[NC_MAX_NAME + 1] = {};
        size_t length = 0;
        require(::nc_inq_dim(id_, k, name, &length), "dimension");
        dimensions_.push_back({name, length});
    }
    for (int k = 0; k < variables; ++k) variables_.push_back(variable_of(id_, k));
    for (const NetcdfVariable& variable : variables_)
        for (const int dimension : variable.dimensions)
            if (dimension < 0 || dimension >= dimensions)
                throw InputError(variable.name + ": expected dimensions of the root group");
}

NetcdfFile::~NetcdfFile() { ::nc_close(id_); }

const NetcdfVariable* NetcdfFile::variable(const std::string& name) const
{
    for (const NetcdfVariable& variable : variables_)
        if (variable.name == name) return &variable;
    return nullptr;
}

size_t NetcdfFile::size(const NetcdfVariable& variable) const
{
    size_t product = 1;
    for (const int dimension : variable.dimensions) product *= dimensions_[size_t(dimension)].length;
    return product;
}

double NetcdfFile::number(const NetcdfVariable& variable, const char* key, double otherwise) const
{
    size_t length = 0;
    double value = otherwise;
    if (::nc_inq_attlen(id_, variable.id, key, &length) != NC_NOERR || length != 1) return otherwise;
    return ::nc_get_att_double(id_, variable.id, key, &value) == NC_NOERR ? value : otherwise;
}

std::vector<float> NetcdfFile::floats(const NetcdfVariable& variable, const std::vector<size_t>& start,
                                      const std::vector<size_t>& count) const
{
    size_t product = 1;
    for (const size_t n : count) {
        if (n > 0 && product > (size_t(1) << 28) / n)
            throw InputError(variable.name + ": expected at most 2^28 values of one time");
        product *= n;
    }
    std::vector<float> values(product);
    // A scalar has no start and count; the library then ignores the pointers.
    const int status = ::nc_get_vara_float(id_, variable.id, start.data(), count.data(), values.data());
    if (status != NC_ERANGE) require(status, variable.name);  // a double that no float holds becomes infinite
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const auto fill = float(number(variable, "_FillValue", none)),
               missing = float(number(variable, "missing_value", none));
    const double scale = number(variable, "scale_factor", 1), offset = number(variable, "add_offset", 0);
    for (float& value : values)
        if (value == fill || value == missing || std::abs(value) > 0.99f * NC_FILL_FLOAT)
            value = std::numeric_limits<float>::quiet_NaN();
        else if (scale != 1 || offset != 0)
            value = float(double(value) * scale + offset);
    return values;
}

std::vector<double> NetcdfFile::doubles(const NetcdfVariable& variable) const
{
    if (size(variable) > size_t(1) << 24) throw InputError(variable.name + ": expected at most 2^24 values");
    std::vector<double> values(size(variable));
    const int status = ::nc_get_var_double(id_, variable.id, values.data());
    if (status != NC_ERANGE) require(status, variable.name);
    const double scale = number(variable, "scale_factor", 1), offset = number(variable, "add_offset", 0);
    for (double& value : values) value = value * scale + offset;
    return values;
}

}  // namespace vdbcloud
