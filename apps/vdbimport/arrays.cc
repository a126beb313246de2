// Arrays of numbers, and property files of SHDOM.
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/property_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// Values that no density has, as 0, with a warning.
void clamp(app::App& app, const std::string& input, std::vector<float>& values)
{
    size_t bad = 0, negative = 0;
    for (float& value : values) {
        bad += !std::isfinite(value);
        negative += value < 0 && std::isfinite(value);
        if (!(value > 0) || !std::isfinite(value)) value = 0;
    }
    if (bad > 0)
        app.warnings()(printable(input) + ": " + std::to_string(bad) + " values that are not finite taken as 0");
    if (negative > 0)
        app.warnings()(printable(input) + ": " + std::to_string(negative) + " negative values taken as 0");
}

ArrayLayout layout_of(const Options& o)
{
    ArrayLayout layout;
    layout.axes = o.axes;
    layout.type = o.type;
    layout.big_endian = o.big_endian;
    for (int a = 0; a < 3; ++a) {
        if (o.shape[a] != std::floor(o.shape[a]) || !(o.shape[a] <= 1 << 28))
            throw UsageError("--shape: expected three whole numbers up to 2^28");
        layout.shape[size_t(a)] = size_t(o.shape[a]);
    }
    return layout;
}

/// The albedo of a property file, as one number, and a grid of factors where it varies.
Vec3SGridPtr albedo_of(app::App& app, const PropertyField& field, UpAxis up, const FloatGrid& density, double& albedo)
{
    float least = 1, most = 0;
    for (size_t k = 0; k < field.albedo.size(); ++k)
        if (field.extinction[k] > 0) {
            least = std::min(least, field.albedo[k]);
            most = std::max(most, field.albedo[k]);
        }
    albedo = double(most);
    if (!(most - least > 1e-6f)) return nullptr;
    app.say("albedo " + app::brief(double(least)) + " to " + app::brief(double(most)) +
            ": the largest is the medium's, grid 'Cd' has the ratio to it");
    auto ratio = Vec3SGrid::create(Vec3f(1));
    ratio->setName(schema::colour);
    ratio->setTransform(density.transform().copy());
    auto set = ratio->getAccessor();
    size_t at = 0;
    for (size_t k = 0; k < field.cells.count(2); ++k)
        for (size_t j = 0; j < field.cells.count(1); ++j)
            for (size_t i = 0; i < field.cells.count(0); ++i, ++at) {
                const auto index = cell_index(field.cells, up, i, j, k);
                if (field.extinction[at] > 0)
                    set.setValueOn({index[0], index[1], index[2]}, Vec3f(field.albedo[at] / most));
            }
    return ratio;
}

}  // namespace

void import_array(app::App& app, const Options& o)
{
    if (o.is(Format::Raw) && !(o.shape[0] > 0))
        throw UsageError("--shape is missing: a raw array needs --shape NX,NY,NZ, its numbers along x, y and z");
    Array array = o.is(Format::Npy) ? read_npy(o.input, o.axes) : read_raw(o.input, layout_of(o));
    const auto& n = array.shape;
    if (ended(app, plan_of_voxels(double(array.values.size()), 1, 0, "a smaller array"),
              std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]) + " numbers"))
        return;
    clamp(app, o.input, array.values);
    const Vec3d size = o.option.cell.given() ? o.cell : Vec3d(1.0);
    Cells cells;
    for (size_t a = 0; a < 3; ++a) cells.edges[a] = equal_edges(0, size[int(a)], n[a]);
    // Indices are the world's axes, whichever of them points up.
    const FloatGridPtr grid = cell_grid(cells, array.values, UpAxis::Z, 1, 1);
    grid->setName(schema::density);
    const UpAxis up = o.up.value_or(UpAxis::Y);
    app.say(std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]) +
            " numbers along x, y, z, " + o.axes + " from the slowest to the fastest; cells of " + app::brief(size) +
            (o.option.cell.given() ? "" : ", assumed (--cell)") + "; up axis " + (up == UpAxis::Z ? "z" : "y"));
    if (grid->empty()) app.warnings()(printable(o.input) + ": no number is above 0: the density is empty");
    write_import(app, o, o.output, {grid}, up, o.meters_per_unit, false);
}

void import_properties(app::App& app, const Options& o)
{
    const PropertyField field = read_property_file(o.input, o.cell);
    for (const std::string& line : field.said) app.say(line);
    if (ended(app, plan_of_voxels(double(field.cells.size()), 5, 0, "larger cells (--cell)"),
              std::to_string(field.cells.size()) + " grid points"))
        return;
    const UpAxis up = o.up.value_or(UpAxis::Z);
    const FloatGridPtr density = cell_grid(field.cells, field.extinction, up, 1, 1);
    density->setName(schema::density);
    std::vector<GridBasePtr> grids{density};
    double albedo = 1;
    if (const Vec3SGridPtr ratio = albedo_of(app, field, up, *density, albedo)) grids.push_back(ratio);
    if (const FloatGridPtr warm = cell_grid(field.cells, field.temperature, up, 1, 1); !warm->empty()) {
        warm->setName(schema::temperature);
        set_text(*warm, schema::unit, "K");
        grids.push_back(warm);
    }
    set_vector(*density, schema::albedo, Vec3d(albedo));
    set_text(*density, schema::phase, "henyey-greenstein");
    set_number(*density, schema::g, field.g);
    const double unit = o.meters_per_unit > 0 ? o.meters_per_unit : 1000;
    app.say("albedo " + app::brief(albedo) + ", mean cosine " + app::brief(field.g) +
            " of the file's phase functions, taken as henyey-greenstein; up axis " + (up == UpAxis::Z ? "z" : "y") +
            ", " + app::brief(unit) + " metres per world unit" +
            (o.meters_per_unit > 0 ? "" : ", assumed (--meters-per-unit)"));
    write_import(app, o, o.output, grids, up, unit, true);
}

}  // namespace vdbcloud
