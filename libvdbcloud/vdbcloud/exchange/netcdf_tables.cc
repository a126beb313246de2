#include "vdbcloud/exchange/netcdf_tables.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <netcdf.h>

namespace vdbcloud {

namespace {

/// An open file of netCDF: each step throws IoError with the library's words.
class Writer {
public:
    Writer(const std::string& path, const std::string& temporary) : path_(path)
    {
        require(::nc_create(temporary.c_str(), NC_CLOBBER | NC_64BIT_OFFSET, &id_));
        open_ = true;
    }
    ~Writer()
    {
        if (open_) ::nc_abort(id_);
    }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    void require(int status) const
    {
        if (status != NC_NOERR) throw IoError(path_ + ": cannot write netCDF: " + ::nc_strerror(status));
    }
    void text(int variable, const char* key, const std::string& value) const
    {
        require(::nc_put_att_text(id_, variable, key, value.size(), value.data()));
    }
    int id() const { return id_; }
    void close()
    {
        open_ = false;
        require(::nc_close(id_));
    }

private:
    std::string path_;
    int id_ = -1;
    bool open_ = false;
};

}  // namespace

void write_netcdf(const std::string& path, const NetcdfTables& tables)
{
    AtomicFile file(path);
    Writer to(path, file.name());
    std::vector<int> dimensions, variables;
    for (const auto& [name, length] : tables.dimensions) {
        dimensions.push_back(-1);
        to.require(::nc_def_dim(to.id(), name.c_str(), length, &dimensions.back()));
    }
    for (const NetcdfColumn& column : tables.columns) {
        std::vector<int> along;
        for (const size_t d : column.dimensions) along.push_back(dimensions.at(d));
        variables.push_back(-1);
        to.require(
            ::nc_def_var(to.id(), column.name.c_str(), NC_DOUBLE, int(along.size()), along.data(), &variables.back()));
        to.text(variables.back(), "units", column.unit.empty() ? "1" : column.unit);
        to.text(variables.back(), "long_name", column.meaning);
    }
    for (const auto& [key, value] : tables.attributes) to.text(NC_GLOBAL, key.c_str(), value);
    to.require(::nc_enddef(to.id()));
    for (size_t v = 0; v < variables.size(); ++v)
        to.require(::nc_put_var_double(to.id(), variables[v], tables.columns[v].values.data()));
    to.close();
    file.commit();
}

}  // namespace vdbcloud
