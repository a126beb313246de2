#pragma once
// The dimensions, variables and attributes of a netCDF file that is open. Private to exchange/.
//
// Damaged files break the libraries below libnetcdf: read files of strangers within read_guarded().
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace vdbcloud {

struct NetcdfVariable {
    int id = -1;
    std::string name;
    std::vector<int> dimensions;              ///< the slowest first
    std::map<std::string, std::string> text;  ///< attributes that are text

    /// The attribute, or an empty text.
    std::string attribute(const std::string& key) const;
};

struct NetcdfDimension {
    std::string name;
    size_t length = 0;
};

/// A file open for reading; variables of the root group. Throws InputError with libnetcdf's own words.
class NetcdfFile {
public:
    explicit NetcdfFile(const std::string& path);
    ~NetcdfFile();
    NetcdfFile(const NetcdfFile&) = delete;
    NetcdfFile& operator=(const NetcdfFile&) = delete;

    const std::vector<NetcdfDimension>& dimensions() const { return dimensions_; }
    const std::vector<NetcdfVariable>& variables() const { return variables_; }
    /// Null if there is none.
    const NetcdfVariable* variable(const std::string& name) const;
    /// Number of values.
    size_t size(const NetcdfVariable&) const;

    /// Values from `start` on, `count` along each dimension of the variable: packed values unpacked (scale_factor,
    /// add_offset), fill values and those of missing_value as NaN.
    std::vector<float> floats(const NetcdfVariable&, const std::vector<size_t>& start,
                              const std::vector<size_t>& count) const;
    /// All values of a variable of one dimension.
    std::vector<double> doubles(const NetcdfVariable&) const;

private:
    double number(const NetcdfVariable&, const char* key, double otherwise) const;

    int id_ = -1;
    std::vector<NetcdfDimension> dimensions_;
    std::vector<NetcdfVariable> variables_;
};

}  // namespace vdbcloud
