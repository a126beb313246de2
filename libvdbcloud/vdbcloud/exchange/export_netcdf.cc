#include "vdbcloud/exchange/export_netcdf.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"

#include <netcdf.h>

#include <array>
#include <cmath>
#include <functional>

namespace vdbcloud {

namespace {

using openvdb::Coord;
using schema::Role;

/// The box of voxels that is written, and its way to x, y, z with z upwards.
struct Lattice {
    openvdb::CoordBBox box;
    Vec3d first{0, 0, 0},
        step{1, 1, 1};  // of voxel 0 and from voxel to voxel, along the world's axes [m or world unit]
    bool up_y = false, metric = false;
    double metres = 1;  // in a world unit

    /// World axis of x, y, z of the file.
    int axis(int a) const { return up_y ? (a == 0 ? 0 : 3 - a) : a; }
    /// Only y of a file whose up axis is Y runs against its world axis.
    bool against(int a) const { return up_y && a == 1; }
    size_t count(int a) const { return size_t(box.dim()[axis(a)]); }
    bool falls(int a) const { return (step[axis(a)] < 0) != against(a); }
    int index(int a, size_t k) const
    {
        const int w = axis(a);
        return falls(a) ? box.max()[w] - int(k) : box.min()[w] + int(k);
    }
    double coordinate(int a, size_t k) const
    {
        const int w = axis(a);
        const double world = first[w] + step[w] * index(a, k);
        return against(a) ? -world : world;
    }
    Coord voxel(size_t x, size_t y, size_t z) const
    {
        const int at[3] = {index(0, x), index(1, y), index(2, z)};
        Coord all;
        for (int a = 0; a < 3; ++a) all[axis(a)] = at[a];
        return all;
    }
};

bool is_field(const GridBase& grid) { return grid.isType<FloatGrid>() || grid.isType<Vec3SGrid>(); }

/// The grid that gives the lattice: the density, else the first field.
GridBasePtr leading(const GridFile& file)
{
    for (const GridBasePtr& grid : file.grids)
        if (is_field(*grid) && schema::has_role(grid->getName(), Role::Density)) return grid;
    for (const GridBasePtr& grid : file.grids)
        if (is_field(*grid)) return grid;
    throw InputError(printable(file.path) + ": no grid of float or vec3s");
}

Lattice lattice_of(const GridFile& file, const std::vector<GridBasePtr>& grids)
{
    Lattice lattice;
    const Transform& transform = grids.front()->transform();
    if (!transform.isLinear()) throw InputError("the grids' transform is a frustum: expected voxels of one size");
    const auto matrix = transform.baseMap()->getAffineMap()->getMat4();
    for (int row = 0; row < 3; ++row)
        for (int c = 0; c < 3; ++c)
            if (row != c && std::abs(matrix[row][c]) > 1e-9 * std::abs(matrix[row][row]))
                throw InputError("grid '" + printable(grids.front()->getName()) +
                                 "' is rotated or sheared: netCDF needs voxels along the axes of the world");
    lattice.metres = get_number(*file.metadata, schema::meters_per_unit, 0);
    lattice.metric = lattice.metres > 0;
    if (!lattice.metric) lattice.metres = 1;
    lattice.up_y = read_up_axis(*file.metadata).value_or(UpAxis::Y) == UpAxis::Y;
    for (int a = 0; a < 3; ++a) {
        lattice.step[a] = lattice.metres * matrix[a][a];
        lattice.first[a] = lattice.metres * matrix[3][a];
    }
    for (const GridBasePtr& grid : grids) {
        openvdb::CoordBBox box;
        if (grid->baseTree().evalActiveVoxelBoundingBox(box)) lattice.box.expand(box);
    }
    if (lattice.box.empty()) throw InputError(printable(file.path) + ": no active voxel: nothing to write");
    double count = 1;
    for (int a = 0; a < 3; ++a) count *= double(lattice.count(a));
    if (count > 1 << 28)
        throw InputError("the box of the active voxels has " + std::to_string(std::llround(count)) +
                         " voxels: expected at most 2^28");
    return lattice;
}

/// What a variable is and how its values follow from a grid's.
struct Meaning {
    std::string units, standard_name, long_name;
    double factor = 1, offset = 0;
    bool vector = false;  // along x, y, z; else colours
};

Meaning meaning_of(const GridBase& grid, const Lattice& lattice)
{
    const schema::GridKind* kind = schema::kind_of(grid.getName());
    Meaning meaning;
    meaning.units = get_text(grid, schema::unit, "");
    const std::string length = lattice.metric ? "m" : "";
    if (!kind) return meaning;
    meaning.long_name = std::string(kind->name) + " [" + kind->unit + "]";
    switch (kind->role) {
    case Role::Temperature:
        meaning.factor = get_number(grid, schema::kelvin_scale, 1);
        meaning.offset = get_number(grid, schema::kelvin_offset, 0);
        if (!says_kelvin(grid)) break;
        meaning.units = "K";
        meaning.standard_name = "air_temperature";
        break;
    case Role::Velocity:
        meaning.vector = true;
        meaning.factor = lattice.metres;
        meaning.units = lattice.metric ? "m s-1" : "";
        break;
    case Role::Flux: meaning.vector = true; [[fallthrough]];
    case Role::Fluence:
    case Role::Transmittance:
    case Role::Colour: meaning.units = "1"; break;
    case Role::Heating:
    case Role::Emission:
        meaning.factor = 1 / lattice.metres;
        meaning.units = lattice.metric ? "m-1" : "";
        break;
    case Role::Water:
    case Role::Rain: meaning.units = "kg kg-1"; break;
    default: break;
    }
    if (meaning.units.find("world unit") != std::string::npos) meaning.units.clear();
    return meaning;
}

/// A file being written: all variables are declared, then filled.
class Writer {
public:
    Writer(const std::string& path, const AtomicFile& file, const Lattice& lattice) : path_(path), lattice_(lattice)
    {
        require(::nc_create(file.name().c_str(), NC_CLOBBER | NC_64BIT_OFFSET, &id_));
        require(::nc_set_fill(id_, NC_NOFILL, nullptr));
    }
    ~Writer()
    {
        if (id_ >= 0) ::nc_abort(id_);
    }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    void text(int variable, const char* key, const std::string& value)
    {
        if (!value.empty()) require(::nc_put_att_text(id_, variable, key, value.size(), value.c_str()));
    }

    void declare_axes()
    {
        constexpr const char* names[] = {"x", "y", "z"};
        constexpr const char* axes[] = {"X", "Y", "Z"};
        for (int a = 0; a < 3; ++a) {
            require(::nc_def_dim(id_, names[a], lattice_.count(a), &dimensions_[size_t(a)]));
            require(::nc_def_var(id_, names[a], NC_DOUBLE, 1, &dimensions_[size_t(a)], &coordinates_[size_t(a)]));
            const int variable = coordinates_[size_t(a)];
            text(variable, "axis", axes[a]);
            if (lattice_.metric) text(variable, "units", "m");
            text(variable, "long_name",
                 std::string(names[a]) +
                     (lattice_.metric ? " of the cell's middle" : " of the cell's middle [world unit]"));
            if (a == 2) text(variable, "positive", "up");
            text(variable, "standard_name",
                 a == 2   ? "height"
                 : a == 0 ? "projection_x_coordinate"
                          : "projection_y_coordinate");
        }
    }

    /// A variable of `components` values a voxel: 1, or 3 along a dimension of colours or of x, y, z.
    int declare(const std::string& name, bool three, const Meaning& meaning)
    {
        std::vector<int> dimensions;
        if (three) dimensions.push_back(third(meaning.vector));
        for (const size_t a : {size_t(2), size_t(1), size_t(0)}) dimensions.push_back(dimensions_[a]);
        int variable = 0;
        require(::nc_def_var(id_, name.c_str(), NC_FLOAT, int(dimensions.size()), dimensions.data(), &variable));
        text(variable, "units", meaning.units);
        text(variable, "standard_name", meaning.standard_name);
        text(variable, "long_name", meaning.long_name);
        if (three) text(variable, "comment", meaning.vector ? "component: x, y, z" : "channel: r, g, b");
        return variable;
    }

    void end_declarations() { require(::nc_enddef(id_)); }

    void fill_axes()
    {
        for (int a = 0; a < 3; ++a) {
            std::vector<double> values(lattice_.count(a));
            for (size_t k = 0; k < values.size(); ++k) values[k] = lattice_.coordinate(a, k);
            require(::nc_put_var_double(id_, coordinates_[size_t(a)], values.data()));
        }
    }

    /// value(voxel) of component `part`; -1: the variable has no components.
    void fill(int variable, int part, const std::function<float(const Coord&)>& value)
    {
        const size_t n[3] = {lattice_.count(0), lattice_.count(1), lattice_.count(2)};
        std::vector<float> layer(n[0] * n[1]);
        for (size_t z = 0; z < n[2]; ++z) {
            size_t at = 0;
            for (size_t y = 0; y < n[1]; ++y)
                for (size_t x = 0; x < n[0]; ++x) layer[at++] = value(lattice_.voxel(x, y, z));
            std::vector<size_t> start{z, 0, 0}, count{1, n[1], n[0]};
            if (part >= 0) {
                start.insert(start.begin(), size_t(part));
                count.insert(count.begin(), 1);
            }
            require(::nc_put_vara_float(id_, variable, start.data(), count.data(), layer.data()));
        }
    }

    void close()
    {
        const int id = id_;
        id_ = -1;
        require(::nc_close(id));
    }

private:
    void require(int status) const
    {
        if (status != NC_NOERR) throw IoError(printable(path_, 4096) + ": cannot write: " + ::nc_strerror(status));
    }

    int third(bool vector)
    {
        int& dimension = vector ? component_ : channel_;
        if (dimension < 0) require(::nc_def_dim(id_, vector ? "component" : "channel", 3, &dimension));
        return dimension;
    }

    std::string path_;
    const Lattice& lattice_;
    int id_ = -1, channel_ = -1, component_ = -1;
    std::array<int, 3> dimensions_{}, coordinates_{};
};

/// A variable, its grid, and what its values are.
struct Field {
    std::string name;
    GridBasePtr grid;
    Meaning meaning;
    Vec3d factor{1, 1, 1};  // of each channel, beside that of the meaning
    bool three = false;
    int variable = -1;
};

/// The extinction of a density [1/m, or 1/world unit].
std::vector<Field> extinction_of(const GridBasePtr& density, const Lattice& lattice)
{
    const Vec3d sigma = get_vector(*density, schema::sigma_t_per_density, Vec3d(0.0));
    if (!density->isType<FloatGrid>() || !(sigma[0] > 0)) return {};
    Field field{"extinction", density, {}, sigma, false, -1};
    field.three = sigma[0] != sigma[1] || sigma[0] != sigma[2];
    field.meaning.factor = 1 / lattice.metres;
    field.meaning.units = lattice.metric ? "m-1" : "";
    field.meaning.standard_name = "volume_extinction_coefficient_in_air_due_to_cloud_particles";
    return {field};
}

std::vector<Field> fields_of(const std::vector<GridBasePtr>& grids, const Lattice& lattice)
{
    std::vector<Field> fields;
    for (const GridBasePtr& grid : grids) {
        Field field{grid->getName(), grid, meaning_of(*grid, lattice), Vec3d(1.0), grid->isType<Vec3SGrid>(), -1};
        fields.push_back(field);
        if (schema::has_role(grid->getName(), Role::Density) && grid->getName() == schema::density)
            for (const Field& extinction : extinction_of(grid, lattice)) fields.push_back(extinction);
    }
    return fields;
}

void fill(Writer& writer, const Field& field, const Lattice& lattice)
{
    for (int part = 0; part < (field.three ? 3 : 1); ++part) {
        const bool vector = field.three && field.meaning.vector;
        const int component = vector ? lattice.axis(part) : part;
        const double sign = vector && lattice.against(part) ? -1 : 1;
        const double factor = sign * field.meaning.factor * (vector ? 1 : field.factor[part]),
                     offset = field.meaning.offset;
        if (const auto scalar = std::dynamic_pointer_cast<FloatGrid>(field.grid)) {
            const auto value = scalar->getConstAccessor();
            writer.fill(field.variable, field.three ? part : -1,
                        [&](const Coord& at) { return float(factor * double(value.getValue(at)) + offset); });
        } else if (const auto vectors = std::dynamic_pointer_cast<Vec3SGrid>(field.grid)) {
            const auto value = vectors->getConstAccessor();
            writer.fill(field.variable, part,
                        [&](const Coord& at) { return float(factor * double(value.getValue(at)[component])); });
        }
    }
}

}  // namespace

std::vector<std::string> write_netcdf(const std::string& path, const GridFile& file, const std::string& history,
                                      bool no_clobber)
{
    std::vector<std::string> said;
    const GridBasePtr lead = leading(file);
    std::vector<GridBasePtr> grids{lead};
    for (const GridBasePtr& grid : file.grids) {
        if (grid == lead) continue;
        bool twice = false;
        for (const GridBasePtr& other : grids) twice = twice || other->getName() == grid->getName();
        const char* const why = !is_field(*grid)                           ? "its type is neither float nor vec3s"
                                : grid->transform() != lead->transform()   ? "its voxels are not those of the first"
                                : twice                                    ? "another grid has its name"
                                : grid->baseTree().activeVoxelCount() == 0 ? "it has no voxels"
                                                                           : nullptr;
        if (why)
            said.push_back("grid '" + printable(grid->getName()) + "' is left out: " + why);
        else
            grids.push_back(grid);
    }
    const Lattice lattice = lattice_of(file, grids);
    if (!lattice.metric)
        said.emplace_back("the file has no meters_per_unit: lengths are in world units, without an attribute units");
    std::vector<Field> fields = fields_of(grids, lattice);
    AtomicFile output(path, no_clobber);
    if (!output.seekable())
        throw IoError(printable(path, 4096) + ": expected a file: netCDF cannot be written to a pipe");
    Writer writer(path, output, lattice);
    writer.text(NC_GLOBAL, "Conventions", "CF-1.8");
    writer.text(NC_GLOBAL, "source", get_text(*file.metadata, schema::creator, ""));
    writer.text(NC_GLOBAL, "history", history);
    writer.declare_axes();
    for (Field& field : fields) field.variable = writer.declare(field.name, field.three, field.meaning);
    writer.end_declarations();
    writer.fill_axes();
    for (const Field& field : fields) fill(writer, field, lattice);
    writer.close();
    output.commit();
    return said;
}

}  // namespace vdbcloud
