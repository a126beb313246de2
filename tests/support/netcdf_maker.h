#pragma once
// netCDF files for tests, made variable by variable.
#include <map>
#include <string>
#include <vector>

namespace vdbcloud::test {

class NetcdfMaker {
public:
    /// `hdf5`: netCDF-4, else the classic format.
    explicit NetcdfMaker(const std::string& path, bool hdf5 = false);
    ~NetcdfMaker();
    NetcdfMaker(const NetcdfMaker&) = delete;
    NetcdfMaker& operator=(const NetcdfMaker&) = delete;

    void dimension(const std::string& name, size_t length);
    /// A variable of doubles; the last dimension is the fastest.
    void variable(const std::string& name, const std::vector<std::string>& dimensions,
                  const std::vector<double>& values, const std::map<std::string, std::string>& attributes = {});
    /// A number as an attribute of a variable.
    void number(const std::string& variable, const std::string& key, double value);

private:
    int id_ = -1;
    std::map<std::string, int> dimensions_;
};

/// A cloud of 2 times, 3 levels, 4 x 5 columns, as a model writes it: qc [g/kg], p [hPa], T [K], z stretched and
/// falling. The water of time t, level k from below, column i, j is model_water().
void write_model(const std::string& path, bool hdf5 = false);
/// [kg/m^3]
double model_water(int t, int i, int j, int k);
/// Edges of the three levels [m], rising.
std::vector<double> model_levels();

}  // namespace vdbcloud::test
