// Fields of cloud models in netCDF files.
#include "frames.h"
#include "import.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <algorithm>
#include <numeric>

namespace vdbcloud {

namespace {

CloudFieldOptions options_of(const Options& o)
{
    CloudFieldOptions options;
    options.variables = pairs_of("--variable", o.variables);
    const auto& roles = cloud_field_roles();
    for (const auto& [role, name] : options.variables)
        if (std::find(roles.begin(), roles.end(), role) == roles.end())
            throw UsageError("--variable " + printable(role + "=" + name) + ": no role '" + printable(role) +
                             "' of a field: see --help");
    options.units = pairs_of("--unit", o.units);
    options.cell = o.cell;
    options.effective_radius = o.effective_radius * 1e-6;
    options.air_density = o.air_density;
    return options;
}

/// The times to read. Throws UsageError for times that the file does not have, and for several into one file.
std::vector<size_t> times_of(const Options& o, size_t count, bool numbered)
{
    std::vector<size_t> times(count);
    std::iota(times.begin(), times.end(), size_t(0));
    if (!o.times.empty()) {
        times.clear();
        for (const int time : app::frame_numbers(o.times)) {
            if (size_t(time) >= count)
                throw UsageError("--times " + printable(o.times) + ": no time " + std::to_string(time) + " in " +
                                 printable(o.input) + ": expected 0 to " + std::to_string(count - 1));
            times.push_back(size_t(time));
        }
    }
    if (times.size() > 1 && !numbered)
        throw UsageError(printable(o.input) + " holds " + std::to_string(count) +
                         " times: expected one, as --times 0, or a numbered --output, as cloud.%04d.vdb");
    return times;
}

void say_field(app::App& app, const Options& o, const CloudField& field, const FloatGrid& grid)
{
    for (const std::string& line : field.said) app.say(line);
    double depth = 0;
    for (const float value : field.extinction) depth += double(value);
    depth *= field.cells.length(2) / double(field.cells.count(2));
    depth /= double(field.cells.count(0) * field.cells.count(1));
    app.report()["field"]["mean_optical_depth"] = depth;
    app.report()["field"]["water"] = field.water;
    app.say(std::to_string(grid.activeVoxelCount()) + " voxels of matter; mean optical depth of the columns " +
            app::brief(depth));
    if (grid.empty()) app.warnings()(printable(o.input) + ": no cell is above 0: the density is empty");
}

/// Options that all times of the file make idle.
void check_effects(const Options& o, bool used_radius, bool used_air_density)
{
    o.option.effective_radius.check_effect(used_radius, "cells of water without an effective radius of their own");
    o.option.air_density.check_effect(used_air_density, "water per mass of air without density of air in the file");
}

}  // namespace

void import_model(app::App& app, const Options& o)
{
    const CloudFieldOptions options = options_of(o);
    const auto pattern = app::FramePattern::in("--output", o.output);
    const std::vector<size_t> times = times_of(o, cloud_field_times(o.input, options), bool(pattern));
    const UpAxis up = o.up.value_or(UpAxis::Z);
    const double unit = o.meters_per_unit > 0 ? o.meters_per_unit : 1;
    bool used_radius = false, used_air_density = false;
    for (const size_t time : times) {
        const CloudField field = read_cloud_field(o.input, options, time);
        used_radius = used_radius || field.used_radius;
        used_air_density = used_air_density || field.used_air_density;
        if (time == times.back()) check_effects(o, used_radius, used_air_density);
        if (ended(app, plan_of_voxels(double(field.cells.size()), 1, 0, "larger cells (--cell)"),
                  std::to_string(times.size()) + " times of " + std::to_string(field.cells.size()) + " cells"))
            return;
        const FloatGridPtr grid = cell_grid(field.cells, field.extinction, up, unit, unit);
        grid->setName(schema::density);
        set_text(*grid, schema::unit, "1/world unit");
        if (field.radius > 0) set_number(*grid, schema::effective_radius, field.radius);
        if (field.water > 0) set_text(*grid, schema::extinction_formula, "3 L / (2 rho_w r_e)");
        say_field(app, o, field, *grid);
        write_import(app, o, pattern ? pattern->path(int(time)) : o.output, {grid}, up, unit, true);
    }
    app.say(std::string("up axis ") + (up == UpAxis::Z ? "z" : "y") + ", " + app::brief(unit) +
            " metres per world unit" + (o.meters_per_unit > 0 ? "" : ", as the model's"));
}

}  // namespace vdbcloud
