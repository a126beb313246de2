#include "vdbcloud/exchange/netcdf_roles.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// Names of a role, lower case, preferred first.
struct RoleNames {
    std::string role;
    std::vector<std::string> standard, common;
};

const std::vector<RoleNames>& role_names()
{
    static const std::vector<RoleNames> all = {
        {"extinction",
         {"volume_extinction_coefficient_in_air_due_to_cloud_particles"},
         {"extinction", "ext", "sigma_t", "sigma_ext", "beta_ext", "extinction_coefficient"}},
        {"water",
         {"mass_fraction_of_cloud_liquid_water_in_air", "cloud_liquid_water_mixing_ratio",
          "mass_concentration_of_cloud_liquid_water_in_air", "mass_concentration_of_liquid_water_in_air"},
         {"qc", "ql", "qcloud", "lwc", "clw", "clwc", "liquid_water_content", "rc", "qcl", "qn", "l"}},
        {"radius",
         {"effective_radius_of_cloud_liquid_water_particles", "effective_radius_of_cloud_liquid_water_particle",
          "effective_radius_of_stratiform_cloud_liquid_water_particle",
          "effective_radius_of_convective_cloud_liquid_water_particle"},
         {"reff", "r_eff", "re", "effective_radius", "re_cloud", "reffc", "rel"}},
        {"density",
         {"air_density"},
         {"rho", "rho0", "rhoa", "rho_air", "air_density", "dn0", "rhof", "rhobf", "rhoref"}},
        {"pressure", {"air_pressure"}, {"p", "pres", "pressure", "press", "air_pressure", "p0"}},
        {"temperature", {"air_temperature"}, {"tabs", "ta", "temp", "temperature", "t", "tk", "air_temperature"}},
        {"theta", {"air_potential_temperature"}, {"theta", "th", "potential_temperature"}},
        {"x",
         {"projection_x_coordinate", "grid_longitude", "longitude"},
         {"x", "xt", "xc", "xh", "west_east", "nx", "lon", "longitude", "ni", "xdim", "x_dim"}},
        {"y",
         {"projection_y_coordinate", "grid_latitude", "latitude"},
         {"y", "yt", "yc", "yh", "south_north", "ny", "lat", "latitude", "nj", "ydim", "y_dim"}},
        {"z",
         {"height", "altitude", "height_above_reference_ellipsoid", "height_above_mean_sea_level", "depth",
          "atmosphere_height_coordinate"},
         {"z", "zt", "zc", "zh", "zf", "zm", "height", "altitude", "alt", "lev", "level", "bottom_top", "nz", "nk",
          "zu_3d", "zdim", "z_dim"}},
        {"time", {"time"}, {"time", "t", "times", "nt", "tdim"}},
    };
    return all;
}

const RoleNames& names_of(const std::string& role)
{
    return *std::find_if(role_names().begin(), role_names().end(), [&](const RoleNames& n) { return n.role == role; });
}

std::string lower(std::string text)
{
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return text;
}

bool holds(const std::vector<std::string>& texts, const std::string& text)
{
    return std::find(texts.begin(), texts.end(), text) != texts.end();
}

constexpr const char* axis_roles[] = {"x", "y", "z", "time"};
constexpr const char* axis_letters = "XYZT";

/// The axis that a variable of one dimension describes: 0 to 3, or -1.
int axis_of_coordinate(const NetcdfVariable& variable)
{
    const std::string axis = variable.attribute("axis"), standard = lower(variable.attribute("standard_name"));
    for (int a = 0; a < 4; ++a)
        if (axis == std::string(1, axis_letters[a])) return a;
    for (int a = 0; a < 4; ++a)
        if (holds(names_of(axis_roles[a]).standard, standard)) return a;
    if (variable.attribute("units").find(" since ") != std::string::npos) return 3;
    if (!variable.attribute("positive").empty()) return 2;
    for (int a = 0; a < 4; ++a)
        if (holds(names_of(axis_roles[a]).common, lower(variable.name))) return a;
    return -1;
}

/// The coordinate of a dimension: the variable that the options name, of the dimension's name, or one along this
/// dimension alone that describes `axis`.
const NetcdfVariable* coordinate_of(const NetcdfFile& file, const CloudFieldOptions& options, int dimension, int axis)
{
    const auto along = [&](const NetcdfVariable& v) { return v.dimensions == std::vector<int>{dimension}; };
    if (const auto named = options.variables.find(axis_roles[axis]); named != options.variables.end())
        if (const NetcdfVariable* variable = file.variable(named->second); variable && along(*variable))
            return variable;
    const std::string& name = file.dimensions()[size_t(dimension)].name;
    if (const NetcdfVariable* variable = file.variable(name); variable && along(*variable)) return variable;
    for (const NetcdfVariable& variable : file.variables())
        if (along(variable) && axis_of_coordinate(variable) == axis) return &variable;
    return nullptr;
}

/// The axis of a dimension, or -1 if neither options nor names tell.
int axis_of_dimension(const NetcdfFile& file, const CloudFieldOptions& options, int dimension)
{
    const std::string& name = file.dimensions()[size_t(dimension)].name;
    for (int a = 0; a < 4; ++a) {
        const auto named = options.variables.find(axis_roles[a]);
        if (named == options.variables.end()) continue;
        const NetcdfVariable* variable = file.variable(named->second);
        if (named->second == name || (variable && variable->dimensions == std::vector<int>{dimension})) return a;
    }
    if (const NetcdfVariable* variable = file.variable(name); variable && variable->dimensions.size() == 1)
        if (const int axis = axis_of_coordinate(*variable); axis >= 0) return axis;
    for (int a = 0; a < 4; ++a)
        if (holds(names_of(axis_roles[a]).common, lower(name))) return a;
    return -1;
}

/// Dimensions that nothing describes are those that are missing, in CF's order: time, z, y, x.
void assign_rest(const NetcdfFile& file, const NetcdfVariable& variable, NetcdfAxes& axes,
                 std::vector<std::string>& said)
{
    std::string order;
    int next = 0;
    for (auto d = variable.dimensions.rbegin(); d != variable.dimensions.rend(); ++d) {
        if (std::find(axes.dimension.begin(), axes.dimension.end(), *d) != axes.dimension.end()) continue;
        const std::string& name = file.dimensions()[size_t(*d)].name;
        while (next < 4 && axes.dimension[size_t(next)] >= 0) ++next;
        if (next == 4)
            throw InputError(variable.name + ": dimension '" + name +
                             "': expected x, y, z and time; name the dimension of an axis with --variable x=NAME");
        axes.dimension[size_t(next)] = *d;
        order += (order.empty() ? "" : ", ") + name + " as " + axis_roles[next];
    }
    if (!order.empty()) said.push_back("dimensions taken by CF's order time, z, y, x: " + order);
}

/// Edges of a coordinate with CF bounds, or none.
std::vector<double> edges_of_bounds(const NetcdfFile& file, const NetcdfVariable& coordinate, bool falls, double metres)
{
    const NetcdfVariable* bounds = file.variable(coordinate.attribute("bounds"));
    const size_t n = file.size(coordinate);
    if (!bounds || bounds->dimensions.size() != 2 || file.size(*bounds) != 2 * n) return {};
    std::vector<double> pairs = file.doubles(*bounds);
    std::vector<double> edges(n + 1);
    for (size_t k = 0; k < n; ++k) {
        const size_t from = falls ? n - 1 - k : k;
        const double one = metres * pairs[2 * from], other = metres * pairs[2 * from + 1], high = std::max(one, other);
        edges[k] = std::min(one, other);
        if (k + 1 == n) edges[n] = high;
        const double low = edges[k];
        if (k > 0 && !(low > edges[k - 1]))
            throw InputError(bounds->name + ": expected bounds that rise or fall throughout");
        if (!(high > low)) throw InputError(bounds->name + ": expected a lower and an upper bound");
    }
    return edges;
}

/// Metres of the unit of a coordinate.
double metres_of(const NetcdfVariable& coordinate, const CloudFieldOptions& options, const char* axis,
                 std::vector<std::string>& said)
{
    const auto unit = unit_of(coordinate, options);
    if (!unit) {
        said.push_back(std::string("axis ") + axis + ": '" + coordinate.name + "' has no units, taken as metres");
        return 1;
    }
    if (!unit->same_kind({1, 0, 1}))
        throw InputError(coordinate.name + ": units '" + unit_text(coordinate, options) +
                         "': expected a length, as m or km; --cell DX,DY,DZ in metres or --unit " + coordinate.name +
                         "=m replaces them, or name another coordinate with --variable " + axis + "=NAME");
    return unit->factor;
}

/// Whether a coordinate has a unit that is no length, as degrees.
bool is_no_length(const NetcdfVariable& coordinate, const CloudFieldOptions& options)
{
    const std::string text = unit_text(coordinate, options);
    const auto unit = parse_unit(text);
    return !text.empty() && !(unit && unit->same_kind({1, 0, 1}));
}

/// Edges of the axis `a`, and whether its coordinate falls.
void set_edges(const NetcdfFile& file, const CloudFieldOptions& options, size_t a, NetcdfAxes& axes,
               std::vector<std::string>& said)
{
    const int dimension = axes.dimension[a];
    const double given = options.cell[int(a)];
    const size_t n = dimension < 0 ? 1 : file.dimensions()[size_t(dimension)].length;
    const char* const axis = axis_roles[a];
    if (n == 0) throw InputError(std::string("axis ") + axis + ": no cells");
    const NetcdfVariable* coordinate = dimension < 0 ? nullptr : coordinate_of(file, options, dimension, int(a));
    if (coordinate && given > 0 && is_no_length(*coordinate, options)) {
        said.push_back("coordinate '" + coordinate->name + "' [" + unit_text(*coordinate, options) +
                       "] is no length: cells of " + shortest(given) + " m from 0 on");
        const std::vector<double> values = file.doubles(*coordinate);
        axes.falls[a] = n > 1 && values.front() > values.back();
        axes.cells.edges[a] = equal_edges(0, given, n);
        return;
    }
    if (!coordinate && dimension >= 0) {
        const std::string& name = file.dimensions()[size_t(dimension)].name;
        if (!(given > 0))
            throw InputError("dimension '" + name + "' (axis " + axis +
                             ") has no coordinate: expected --cell DX,DY,DZ in metres, or the name of its coordinate "
                             "with --variable " +
                             axis + "=NAME");
        said.push_back("dimension '" + name + "' has no coordinate: cells of " + shortest(given) + " m from 0 on");
    }
    if (!coordinate) {
        const size_t other = a == 0 ? 1 : 0;
        const auto& beside = axes.cells.edges[other];
        const double size = given > 0 ? given : beside.size() > 1 ? beside[1] - beside[0] : 1;
        axes.cells.edges[a] = equal_edges(0, size, n);
        if (dimension < 0)
            said.push_back(std::string("no dimension along ") + axis + ": one cell of " + shortest(size) + " m");
        return;
    }
    const bool downwards = a == 2 && coordinate->attribute("positive") == "down";
    const double metres = metres_of(*coordinate, options, axis, said) * (downwards ? -1 : 1);
    std::vector<double> centres = file.doubles(*coordinate);
    for (double& x : centres) x *= metres;
    axes.falls[a] = n > 1 && centres.front() > centres.back();
    if (axes.falls[a]) std::reverse(centres.begin(), centres.end());
    axes.cells.edges[a] = edges_of_bounds(file, *coordinate, axes.falls[a], metres);
    if (!axes.cells.edges[a].empty()) return;
    const auto& beside = axes.cells.edges[a == 0 ? 1 : 0];
    const double single = given > 0 ? given : beside.size() > 1 ? beside[1] - beside[0] : 1;
    axes.cells.edges[a] = edges_between(centres, single, coordinate->name);
    if (n == 1) said.push_back(std::string("axis ") + axis + " has one cell: taken as " + shortest(single) + " m wide");
}

}  // namespace

const std::vector<std::string>& cloud_field_roles()
{
    static const std::vector<std::string> roles = [] {
        std::vector<std::string> all;
        for (const RoleNames& names : role_names()) all.push_back(names.role);
        return all;
    }();
    return roles;
}

const NetcdfVariable* variable_of_role(const NetcdfFile& file, const CloudFieldOptions& options,
                                       const std::string& role)
{
    if (const auto named = options.variables.find(role); named != options.variables.end()) {
        if (const NetcdfVariable* variable = file.variable(named->second)) return variable;
        std::string there;
        for (const NetcdfVariable& variable : file.variables())
            if (there.size() < 300) there += (there.empty() ? "" : ", ") + variable.name;
        throw InputError("no variable '" + named->second + "' (" + role + "): the file has " + there);
    }
    // A coordinate is no field: a file may call its time t, and its temperature T.
    const auto is_field = [&](const NetcdfVariable& v) {
        return !(v.dimensions.size() == 1 && file.dimensions()[size_t(v.dimensions[0])].name == v.name);
    };
    const RoleNames& names = names_of(role);
    for (const std::string& standard : names.standard)
        for (const NetcdfVariable& variable : file.variables())
            if (is_field(variable) && lower(variable.attribute("standard_name")) == standard) return &variable;
    for (const std::string& common : names.common)
        for (const NetcdfVariable& variable : file.variables())
            if (is_field(variable) && lower(variable.name) == common) return &variable;
    return nullptr;
}

std::string unit_text(const NetcdfVariable& variable, const CloudFieldOptions& options)
{
    const auto given = options.units.find(variable.name);
    return given == options.units.end() ? variable.attribute("units") : given->second;
}

std::optional<Unit> unit_of(const NetcdfVariable& variable, const CloudFieldOptions& options)
{
    const std::string text = unit_text(variable, options);
    if (text.empty()) return std::nullopt;
    if (const auto unit = parse_unit(text)) return unit;
    throw InputError(variable.name + ": units '" + text + "': expected units as kg m-3, g/kg, km, um or hPa; --unit " +
                     variable.name + "=UNIT replaces them");
}

NetcdfAxes axes_of(const NetcdfFile& file, const CloudFieldOptions& options, const NetcdfVariable& variable,
                   std::vector<std::string>& said)
{
    NetcdfAxes axes;
    for (const int dimension : variable.dimensions) {
        const int axis = axis_of_dimension(file, options, dimension);
        if (axis < 0) continue;
        if (axes.dimension[size_t(axis)] >= 0)
            throw InputError(variable.name + ": dimensions '" +
                             file.dimensions()[size_t(axes.dimension[size_t(axis)])].name + "' and '" +
                             file.dimensions()[size_t(dimension)].name + "' both look like " + axis_roles[axis] +
                             ": name that of an axis with --variable " + axis_roles[axis] + "=NAME");
        axes.dimension[size_t(axis)] = dimension;
    }
    assign_rest(file, variable, axes, said);
    // The cell of an axis that has none is that of the other horizontal axis.
    const bool y_first = axes.dimension[0] < 0;
    for (const size_t a : {size_t(y_first ? 1 : 0), size_t(y_first ? 0 : 1), size_t(2)})
        set_edges(file, options, a, axes, said);
    return axes;
}

std::vector<float> values_on(const NetcdfFile& file, const NetcdfAxes& axes, const NetcdfVariable& variable,
                             size_t time)
{
    std::vector<size_t> start, count;
    std::array<size_t, 3> stride{};  // of x, y, z in what is read; 0: the variable lacks the axis
    for (const int dimension : variable.dimensions) {
        const size_t length = file.dimensions()[size_t(dimension)].length;
        const auto axis = std::find(axes.dimension.begin(), axes.dimension.end(), dimension) - axes.dimension.begin();
        if (axis == 4 && length != 1)
            throw InputError(variable.name + ": dimension '" + file.dimensions()[size_t(dimension)].name +
                             "': expected the dimensions of the water, or fewer");
        const bool is_space = axis < 3;
        if (axis == 3 && time >= length)
            throw InputError(variable.name + ": no time " + std::to_string(time) + ": the file has " +
                             std::to_string(length));
        start.push_back(axis == 3 ? time : 0);
        count.push_back(is_space ? length : 1);
        for (size_t a = 0; a < 3; ++a) stride[a] *= count.back();
        if (is_space) stride[size_t(axis)] = 1;
    }
    const std::vector<float> read = file.floats(variable, start, count);
    const size_t n[3] = {axes.count(0), axes.count(1), axes.count(2)};
    std::vector<float> values(n[0] * n[1] * n[2]);
    const auto place = [&](size_t a, size_t at) { return stride[a] * (axes.falls[a] ? n[a] - 1 - at : at); };
    size_t at = 0;
    for (size_t k = 0; k < n[2]; ++k)
        for (size_t j = 0; j < n[1]; ++j)
            for (size_t i = 0; i < n[0]; ++i, ++at) values[at] = read[place(0, i) + place(1, j) + place(2, k)];
    return values;
}

}  // namespace vdbcloud
