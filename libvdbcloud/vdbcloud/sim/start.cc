// The first air from a file: grids on any lattice whose axes are the world's, with either axis up, in any unit.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/sim/axes.h"
#include "vdbcloud/sim/snapshot.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::sim {

namespace {

/// One value a cell, i fastest.
using Values = std::vector<double>;

/// A profile of the environment at any height: linear between the levels, and beyond them.
struct Profile {
    std::vector<double> value;
    double dz;

    double at(double z) const
    {
        const double x = z / dz - 0.5;
        const size_t k = size_t(std::clamp(std::floor(x), 0.0, double(value.size()) - 2));
        return value[k] + (x - double(k)) * (value[k + 1] - value[k]);
    }
};

/// Where a cell lies between the voxels of a file, along one axis.
struct Between {
    bool inside = false;
    int voxel[2] = {0, 0};
    double weight[2] = {1, 0};
};

/// A file that holds the first air.
struct Source {
    const GridFile& file;
    Axes axes;
    double metres;  // in a world unit
};

/// A grid beside the cells of a box. A cell lies between two voxels along each axis; half a voxel beyond the outermost
/// ones, these are repeated. Where the grid is as long as a periodic axis, it goes on with its other end.
class Placement {
public:
    /// `component`: the axis of a velocity's component, -1 for what lies at centres. Throws InputError for voxels whose
    /// edges are not along the axes.
    Placement(const Source& source, const GridBase& grid, bool staggered, int component)
        : source_(source), map_(grid.transform()), staggered_(staggered), component_(component)
    {
        const auto linear = map_.isLinear() ? map_.baseMap()->getAffineMap() : nullptr;
        bool along_axes = linear != nullptr;
        for (const int a : {0, 1, 2})
            for (const int b : {0, 1, 2})
                if (a != b && along_axes && linear->getMat4()(a, b) != 0) along_axes = false;
        if (!along_axes)
            throw InputError(
                printable(source.file.path) + ": grid '" + printable(grid.getName()) +
                "' has voxels with slanted edges: expected edges along x, y and z; resample the grid first");
        box_ = grid.evalActiveVoxelBoundingBox();
        if (box_.empty()) return;
        for (const int axis : {0, 1, 2})
            for (int i = 0; i < source.axes.l.n[size_t(axis)]; ++i) along_[size_t(axis)].push_back(between(axis, i));
    }

    const Between& along(int axis, int i) const { return along_[size_t(axis)][size_t(i)]; }
    bool empty() const { return box_.empty(); }
    /// Height of the values in voxel `index` along the axis that is up [m].
    double height(int index) const
    {
        const int up = source_.axes.file_axis(2);
        Vec3d at(0, 0, 0);
        at[up] = index - (staggered_ && component_ == 2 ? 0.5 : 0);
        return map_.indexToWorld(at)[up] * source_.metres;
    }
    /// True if voxels lie elsewhere than cells.
    bool resamples() const
    {
        for (const auto& list : along_)
            for (const Between& b : list)
                if (b.inside && b.weight[0] < 1 && b.weight[1] < 1) return true;
        return false;
    }

private:
    Between between(int axis, int i) const
    {
        const Lattice& l = source_.axes.l;
        const int file = source_.axes.file_axis(axis), low = box_.min()[file], high = box_.max()[file];
        const bool face = axis == component_, own_face = face && staggered_;
        Vec3d world(0, 0, 0);
        world[file] = source_.axes.centre(axis, i - (face ? 0.5 : 0)) / source_.metres;
        double x = map_.worldToIndex(world)[file] + (own_face ? 0.5 : 0);
        const double length = std::abs(map_.voxelSize()[file]) * (high - low + 1) * source_.metres,
                     period = l.n[size_t(axis)] * l.h[size_t(axis)];
        const bool wraps =
            axis < 2 && l.side[size_t(axis)] == Side::Periodic && std::abs(length - period) < 1e-6 * period;
        constexpr double rounding = 1e-6;
        Between b;
        // The last face of a staggered grid is not in the file: there the air is the environment's.
        const double first = own_face ? low : low - 0.5, last = own_face ? high + 1 : high + 0.5;
        b.inside = wraps || (x >= first - rounding && x <= last + rounding);
        if (!b.inside) return b;
        if (!wraps && !own_face) x = std::clamp(x, double(low), double(high));
        if (std::abs(x - std::round(x)) < rounding) x = std::round(x);
        b.voxel[0] = int(std::floor(x)), b.voxel[1] = b.voxel[0] + 1;
        b.weight[1] = x - b.voxel[0], b.weight[0] = 1 - b.weight[1];
        const int count = high - low + 1;
        if (wraps)
            for (int& v : b.voxel) v = low + ((v - low) % count + count) % count;
        return b;
    }

    const Source& source_;
    const openvdb::math::Transform& map_;
    bool staggered_;
    int component_;
    openvdb::CoordBBox box_;
    std::array<std::vector<Between>, 3> along_;
};

/// Trilinear values of a grid in the cells that touch an active voxel. Deviations from the environment at the height of
/// each voxel are interpolated; a voxel that is not active counts as the environment. Calls found(cell, value).
template<typename GridT, typename Of>
void sample(const GridT& grid, const Placement& place, const Axes& axes, const Profile& environment, const Of& of,
            const std::function<void(size_t, double)>& found)
{
    if (place.empty()) return;
    auto accessor = grid.getConstAccessor();
    const Lattice& l = axes.l;
    size_t c = 0;
    for (int k = 0; k < l.n[2]; ++k) {
        const Between& z = place.along(2, k);
        double env[2] = {0, 0};
        for (const size_t e : {0, 1})
            if (z.inside) env[e] = environment.at(place.height(z.voxel[e]));
        for (int j = 0; j < l.n[1]; ++j)
            for (int i = 0; i < l.n[0]; ++i, ++c) {
                const Between &x = place.along(0, i), &y = place.along(1, j);
                if (!x.inside || !y.inside || !z.inside) continue;
                double deviation = 0;
                bool active = false;
                for (const size_t n : {0, 1, 2, 3, 4, 5, 6, 7}) {
                    const size_t a = n & 1, b = n >> 1 & 1, e = n >> 2;
                    const double weight = x.weight[a] * y.weight[b] * z.weight[e];
                    if (weight == 0) continue;
                    typename GridT::ValueType value;
                    const openvdb::Coord at(axes.voxel(x.voxel[a], y.voxel[b], z.voxel[e]));
                    if (!accessor.probeValue(at, value)) continue;
                    active = true;
                    deviation += weight * (of(value) - env[e]);
                }
                if (active) found(c, environment.value[size_t(k)] + deviation);
            }
    }
}

/// A grid in the type that cloudsim reads; null stays null. Throws InputError for another type.
template<typename GridT>
typename GridT::Ptr typed(const GridFile& file, const GridBasePtr& grid)
{
    const auto cast = openvdb::gridPtrCast<GridT>(grid);
    if (grid && !cast)
        throw InputError(printable(file.path) + ": grid '" + printable(grid->getName()) + "' has values of type " +
                         printable(grid->valueType()) + ": expected " +
                         openvdb::typeNameAsString<typename GridT::ValueType>());
    return cast;
}

Values all(const Simulation& sim, Quantity q)
{
    const Lattice& l = sim.parameters().lattice;
    Values values(l.cells());
    for (int k = 0; k < l.n[2]; ++k) sim.get_plane(q, k, &values[size_t(k) * size_t(l.n[0]) * size_t(l.n[1])]);
    return values;
}

/// Environment of a quantity, absolute, or with `temperature` that of T [K] with the heat of its cloud.
Profile profile_of(const Simulation& sim, Quantity q, bool temperature = false)
{
    const Column& column = sim.column();
    const Thermodynamics& thermo = sim.thermodynamics();
    Profile profile{{}, sim.parameters().lattice.h[2]};
    for (size_t k = 0; k < column.level.size(); ++k) {
        const Level& level = column.level[k];
        double value = 0;
        if (q == Quantity::U) value = column.u[k] + sim.parameters().frame[0];
        if (q == Quantity::V) value = column.v[k] + sim.parameters().frame[1];
        if (q == Quantity::Water) value = level.q_env + column.reference.water;
        if (q == Quantity::Theta) value = level.theta_env + column.reference.theta;
        if (temperature) {
            if (sim.has(Quantity::Water) && thermo.terms().latent_heat)
                value += level.heat * thermo.cloud_water(level, level.theta_env, level.q_env);
            if (thermo.terms().by == SaturationBy::Temperature) value *= level.exner;
        }
        profile.value.push_back(value);
    }
    return profile;
}

void set_wind(Simulation& sim, const Source& source, const Vec3SGrid& grid, StartReport& report)
{
    const bool staggered = grid.getGridClass() == openvdb::GRID_STAGGERED;
    report.centred_wind = !staggered;
    for (const int axis : {0, 1, 2}) {
        const Quantity q = std::array{Quantity::U, Quantity::V, Quantity::W}[size_t(axis)];
        if (!sim.has(q)) continue;
        Values values = all(sim, q);
        const Placement place(source, grid, staggered, axis);
        report.resampled |= place.resamples();
        const int component = source.axes.file_axis(axis);
        sample(
            grid, place, source.axes, profile_of(sim, q),
            [&](const Vec3f& v) { return double(v[component]) * source.metres; },
            [&](size_t c, double value) { values[c] = value, ++report.cells_set; });
        sim.set(q, values, printable(source.file.path) + ": vel");
    }
}

/// Returns the total water of each cell.
Values set_water(Simulation& sim, const Source& source, const FloatGrid* grid, StartReport& report)
{
    if (!sim.has(Quantity::Water)) return Values(sim.parameters().lattice.cells(), 0.0);
    Values q_t = all(sim, Quantity::Water);
    if (!grid) return q_t;
    const Placement place(source, *grid, false, -1);
    report.resampled |= place.resamples();
    sample(
        *grid, place, source.axes, profile_of(sim, Quantity::Water), [](float v) { return double(v); },
        [&](size_t c, double value) {
            ++report.cells_set;
            report.negative_water += value < 0;
            q_t[c] = value < 0 ? 0 : value;  // NaN stays: set() refuses it with its cell
        });
    sim.set(Quantity::Water, q_t, printable(source.file.path) + ": qt");
    return q_t;
}

void set_temperature(Simulation& sim, const Source& source, const FloatGrid& grid, const Values& q_t,
                     StartReport& report)
{
    const Lattice& l = sim.parameters().lattice;
    const size_t plane = size_t(l.n[0]) * size_t(l.n[1]);
    const Thermodynamics& thermo = sim.thermodynamics();
    const bool real = thermo.terms().by == SaturationBy::Temperature;
    Values theta = all(sim, Quantity::Theta);
    const Placement place(source, grid, false, -1);
    report.resampled |= place.resamples();
    sample(
        grid, place, source.axes, profile_of(sim, Quantity::Theta, true), [](float v) { return double(v); },
        [&](size_t c, double t) {
            ++report.cells_set;
            const Level& level = sim.column().level[c / plane];
            const double q_s = real ? thermo.saturation(t, level.pressure) : level.q_height;
            const double q_l = sim.has(Quantity::Water) ? std::max(0.0, q_t[c] - q_s) : 0;
            const double warm = thermo.terms().latent_heat ? level.heat * q_l : 0;
            theta[c] = t / (real ? level.exner : 1) - warm;
            report.saturated += q_l > 0, report.latent_heat += warm / double(l.cells());
        });
    sim.set(Quantity::Theta, theta, printable(source.file.path) + ": temperature");
}

}  // namespace

StartReport start_from(Simulation& sim, const GridFile& file, UpAxis up)
{
    const auto temperature = typed<FloatGrid>(file, grid_of(file, schema::temperature));
    const auto water = typed<FloatGrid>(file, find_grid(file, schema::water));
    const auto velocity = typed<Vec3SGrid>(file, grid_of(file, schema::velocity));
    if (!temperature && !water && !velocity)
        throw IoError(printable(file.path) + ": expected a grid temperature, qt (float) or vel (vec3s)");
    StartReport report;
    report.up = read_up_axis(*file.metadata).value_or(up);
    const double metres = get_number(*file.metadata, schema::meters_per_unit, 1);
    if (!(metres >= 1e-6 && metres <= 1e6)) refuse(printable(file.path) + ": meters_per_unit", metres, "1e-6..1e6");
    const Source source{file, {sim.parameters().lattice, report.up}, metres};
    if (velocity) set_wind(sim, source, *velocity, report);
    const Values q_t = set_water(sim, source, water.get(), report);
    if (sim.has(Quantity::Theta) && temperature) set_temperature(sim, source, *temperature, q_t, report);
    sim.start();
    return report;
}

}  // namespace vdbcloud::sim
