#include "support/netcdf_maker.h"

#include <netcdf.h>

#include <stdexcept>

namespace vdbcloud::test {

namespace {

void require(int status)
{
    if (status != NC_NOERR) throw std::runtime_error(::nc_strerror(status));
}

double model_density(int k) { return 1.2 - 0.1 * k; }
double model_temperature(int k) { return 290 - 5.0 * k; }

}  // namespace

NetcdfMaker::NetcdfMaker(const std::string& path, bool hdf5)
{
    require(::nc_create(path.c_str(), hdf5 ? NC_NETCDF4 : NC_CLOBBER, &id_));
}

NetcdfMaker::~NetcdfMaker() { ::nc_close(id_); }

void NetcdfMaker::dimension(const std::string& name, size_t length)
{
    ::nc_redef(id_);
    require(::nc_def_dim(id_, name.c_str(), length, &dimensions_[name]));
}

void NetcdfMaker::variable(const std::string& name, const std::vector<std::string>& dimensions,
                           const std::vector<double>& values, const std::map<std::string, std::string>& attributes)
{
    ::nc_redef(id_);
    std::vector<int> ids;
    for (const std::string& dimension : dimensions) ids.push_back(dimensions_.at(dimension));
    int variable = 0;
    require(::nc_def_var(id_, name.c_str(), NC_DOUBLE, int(ids.size()), ids.data(), &variable));
    for (const auto& [key, text] : attributes)
        require(::nc_put_att_text(id_, variable, key.c_str(), text.size(), text.c_str()));
    ::nc_enddef(id_);
    require(::nc_put_var_double(id_, variable, values.data()));
}

void NetcdfMaker::number(const std::string& variable, const std::string& key, double value)
{
    int id = 0;
    ::nc_redef(id_);
    require(::nc_inq_varid(id_, variable.c_str(), &id));
    require(::nc_put_att_double(id_, id, key.c_str(), NC_DOUBLE, 1, &value));
    ::nc_enddef(id_);
}

double model_water(int t, int i, int j, int k) { return 1e-4 * (t + 1) * (1 + i + 2 * j) * (k + 1); }

std::vector<double> model_levels() { return {0, 100, 250, 450}; }

void write_model(const std::string& path, bool hdf5)
{
    NetcdfMaker file(path, hdf5);
    const std::map<std::string, size_t> sizes{{"time", 2}, {"z", 3}, {"y", 4}, {"x", 5}};
    for (const auto& [name, size] : sizes) file.dimension(name, size);
    file.dimension("two", 2);
    file.variable("time", {"time"}, {0, 60}, {{"units", "seconds since 2000-01-01"}});
    file.variable("x", {"x"}, {0.025, 0.075, 0.125, 0.175, 0.225}, {{"units", "km"}, {"axis", "X"}});
    file.variable("y", {"y"}, {10, 30, 50, 70}, {{"units", "m"}, {"axis", "Y"}});
    file.variable("z", {"z"}, {350, 175, 50}, {{"units", "m"}, {"positive", "up"}, {"bounds", "z_edges"}});
    file.variable("z_edges", {"z", "two"}, {250, 450, 100, 250, 0, 100});
    std::vector<double> water, temperature, pressure;
    for (int t = 0; t < 2; ++t)
        for (int k = 2; k >= 0; --k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 5; ++i) water.push_back(1e3 * model_water(t, i, j, k) / model_density(k));
    for (int k = 2; k >= 0; --k) {
        temperature.push_back(model_temperature(k));
        pressure.push_back(1e-2 * model_density(k) * 287.04 * model_temperature(k));
    }
    file.variable("T", {"z"}, temperature, {{"units", "K"}, {"standard_name", "air_temperature"}});
    file.variable("p", {"z"}, pressure, {{"units", "hPa"}});
    std::vector<double> rain(water.rbegin(), water.rend());
    file.variable("rain", {"time", "z", "y", "x"}, rain, {{"units", "g kg-1"}});
    file.variable("qc", {"time", "z", "y", "x"}, water, {{"units", "g kg-1"}});
}

}  // namespace vdbcloud::test
