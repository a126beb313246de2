#include "vdbcloud/exchange/netcdf_extent.h"

#include "vdbcloud/core/error.h"

#include <netcdf.h>

#include <cstring>
#include <vector>

namespace vdbcloud {

namespace {

void require(int status)
{
    if (status != NC_NOERR) throw InputError(std::string("header: ") + ::nc_strerror(status));
}

uint64_t padded(uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// The lengths of a header's parts. `number`: bytes of a count, `offset`: of a place in the file.
struct Header {
    int file;
    uint64_t number, offset;

    uint64_t name(const char* text) const { return number + padded(std::strlen(text)); }

    uint64_t attributes(int variable, int count) const
    {
        uint64_t bytes = 4 + number;
        for (int k = 0; k < count; ++k) {
            char text[NC_MAX_NAME + 1] = {};
            nc_type type = 0;
            size_t length = 0, each = 0;
            require(::nc_inq_attname(file, variable, k, text));
            require(::nc_inq_att(file, variable, text, &type, &length));
            require(::nc_inq_type(file, type, nullptr, &each));
            bytes += name(text) + 4 + number + padded(length * each);
        }
        return bytes;
    }
};

/// Bytes of the values of one variable, of one record where it grows with the records.
struct Values {
    uint64_t bytes = 0;
    bool grows = false;
};

Values values_of(int file, const std::vector<int>& dimensions, nc_type type, int unlimited)
{
    Values values;
    size_t each = 0;
    require(::nc_inq_type(file, type, nullptr, &each));
    values.bytes = each;
    for (const int dimension : dimensions) {
        size_t length = 0;
        require(::nc_inq_dimlen(file, dimension, &length));
        values.grows = values.grows || dimension == unlimited;
        if (dimension == unlimited) continue;
        if (length > 0 && values.bytes > (uint64_t(1) << 60) / length) throw InputError("header: too many values");
        values.bytes *= length;
    }
    return values;
}

}  // namespace

uint64_t classic_extent(int file)
{
    int format = 0, dimensions = 0, variables = 0, attributes = 0, unlimited = -1;
    require(::nc_inq_format(file, &format));
    if (format != NC_FORMAT_CLASSIC && format != NC_FORMAT_64BIT_OFFSET && format != NC_FORMAT_64BIT_DATA) return 0;
    require(::nc_inq(file, &dimensions, &variables, &attributes, &unlimited));
    const uint64_t number = format == NC_FORMAT_64BIT_DATA ? 8 : 4;
    const Header header{file, number, format == NC_FORMAT_CLASSIC ? uint64_t(4) : uint64_t(8)};
    uint64_t bytes = 4 + number + 2 * (4 + number) + header.attributes(NC_GLOBAL, attributes);
    char name[NC_MAX_NAME + 1] = {};
    size_t records = 0;
    for (int k = 0; k < dimensions; ++k) {
        size_t length = 0;
        require(::nc_inq_dim(file, k, name, &length));
        bytes += header.name(name) + number;
        if (k == unlimited) records = length;
    }
    std::vector<uint64_t> growing;  // bytes of a record
    for (int k = 0; k < variables; ++k) {
        int count = 0, own = 0;
        nc_type type = 0;
        require(::nc_inq_var(file, k, name, &type, &count, nullptr, &own));
        std::vector<int> along(size_t(count), 0);
        if (count > 0) require(::nc_inq_vardimid(file, k, along.data()));
        bytes += header.name(name) + number * (2 + uint64_t(count)) + 4 + header.offset + header.attributes(k, own);
        const Values values = values_of(file, along, type, unlimited);
        if (values.grows)
            growing.push_back(values.bytes);
        else
            bytes += padded(values.bytes);
    }
    // Records of a single variable are not padded.
    for (const uint64_t record : growing) bytes += records * (growing.size() == 1 ? record : padded(record));
    // Padding after the last value may be missing.
    return bytes < 3 ? 0 : bytes - 3;
}

}  // namespace vdbcloud
