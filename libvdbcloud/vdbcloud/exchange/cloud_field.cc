#include "vdbcloud/exchange/cloud_field.h"

#include "vdbcloud/core/of_file.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/exchange/guarded_bytes.h"
#include "vdbcloud/exchange/netcdf_roles.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double water_density = 1000;       // [kg/m^3]
constexpr double usual_radius = 10e-6;       // [m] of droplets, where neither file nor user says one
constexpr double gas_constant_dry = 287.04;  // [J/(kg K)]
constexpr double heat_capacity = 1005;       // [J/(kg K)] of dry air at constant pressure
constexpr double reference_pressure = 1e5;   // [Pa] of the potential temperature

/// Reads the variables of one time. The file, its axes and what is said live as long as the reading.
class Reading {
public:
    Reading(const std::string& path, const CloudFieldOptions& options) : options_(options), file_(path)
    {
        extinction_ = role("extinction");
        if (!extinction_ || options.variables.count("water") > 0) water_ = role("water");
        if (water_) extinction_ = nullptr;
        if (!water_ && !extinction_)
            throw InputError("neither liquid water nor extinction: name its variable with --variable water=NAME");
        axes_ = axes_of(file_, options_, main(), field_.said);
    }

    size_t times() const
    {
        const int dimension = axes_.dimension[3];
        return dimension < 0 ? 1 : file_.dimensions()[size_t(dimension)].length;
    }

    CloudField read(size_t time)
    {
        field_.cells = axes_.cells;
        if (extinction_)
            read_extinction(time);
        else
            read_water(time);
        return std::move(field_);
    }

private:
    const NetcdfVariable* role(const char* name) const { return variable_of_role(file_, options_, name); }
    const NetcdfVariable& main() const { return water_ ? *water_ : *extinction_; }
    void say(const std::string& line) { field_.said.push_back(line); }

    /// Values in the unit `wanted`; a variable without unit, or with one of another kind, is refused.
    std::vector<float> in_units(const NetcdfVariable& variable, const Unit& wanted, const char* expected, size_t time)
    {
        const auto unit = unit_of(variable, options_);
        if (!unit)
            throw InputError(variable.name + ": no units: expected " + expected + "; say them with --unit " +
                             variable.name + "=UNIT");
        if (!unit->same_kind(wanted)) refuse_unit(variable, expected);
        std::vector<float> values = values_on(file_, axes_, variable, time);
        if (unit->factor != wanted.factor)
            for (float& value : values) value = float(double(value) * unit->factor / wanted.factor);
        return values;
    }
    [[noreturn]] void refuse_unit(const NetcdfVariable& variable, const char* expected) const
    {
        throw InputError(variable.name + ": units '" + unit_text(variable, options_) + "': expected " + expected +
                         "; --unit " + variable.name + "=UNIT replaces them");
    }

    /// Negative and missing values as 0, which is said once.
    void clamp(std::vector<float>& values, const std::string& name)
    {
        size_t missing = 0, negative = 0;
        for (float& value : values) {
            missing += !std::isfinite(value);
            negative += value < 0;
            if (!(value > 0) || !std::isfinite(value)) value = 0;
        }
        if (missing > 0) say(std::to_string(missing) + " missing values of '" + name + "' taken as 0");
        if (negative > 0) say(std::to_string(negative) + " negative values of '" + name + "' taken as 0");
    }

    void read_extinction(size_t time)
    {
        field_.extinction = in_units(*extinction_, {1, 0, -1}, "1/m or km-1", time);
        say("extinction from '" + extinction_->name + "' [" + unit_text(*extinction_, options_) + "]");
        clamp(field_.extinction, extinction_->name);
    }

    void read_water(size_t time)
    {
        const Unit content{1, 1, -3}, ratio{};
        const auto unit = unit_of(*water_, options_);
        std::vector<float> water;  // [kg/m^3]
        if (unit && unit->same_kind(ratio)) {
            water = in_units(*water_, ratio, "", time);
            const std::vector<float> air = air_density(time);
            for (size_t k = 0; k < water.size(); ++k) water[k] *= air[k];
        } else {
            water = in_units(*water_, content, "kg/m^3, g/m^3, kg/kg or g/kg", time);
        }
        say("liquid water from '" + water_->name + "' [" + unit_text(*water_, options_) + "]");
        clamp(water, water_->name);
        for (size_t k = 0, at = 0; k < axes_.count(2); ++k)
            for (size_t j = 0; j < axes_.count(1); ++j)
                for (size_t i = 0; i < axes_.count(0); ++i, ++at)
                    field_.water += double(water[at]) * size(0, i) * size(1, j) * size(2, k);
        to_extinction(water, time);
    }

    double size(size_t axis, size_t cell) const
    {
        const auto& edges = axes_.cells.edges[axis];
        return edges[cell + 1] - edges[cell];
    }

    /// Density of air [kg/m^3] in each cell; not finite or 0 where the file's is.
    std::vector<float> air_density(size_t time)
    {
        if (const NetcdfVariable* rho = role("density")) {
            say("density of air from '" + rho->name + "'");
            return in_units(*rho, {1, 1, -3}, "kg m-3", time);
        }
        if (options_.air_density > 0) {
            field_.used_air_density = true;
            say("density of air " + shortest(options_.air_density) + " kg/m^3 everywhere");
            return std::vector<float>(axes_.cells.size(), float(options_.air_density));
        }
        const NetcdfVariable *p = role("pressure"), *t = role("temperature"), *theta = t ? nullptr : role("theta");
        if (p && (t || theta)) {
            const NetcdfVariable& heat = t ? *t : *theta;
            std::vector<float> rho = in_units(*p, {1, 1, -1, -2}, "Pa or hPa", time);
            const std::vector<float> kelvin = in_units(heat, {1, 0, 0, 0, 1}, "K", time);
            require_within(rho, *p, 1, 2e5, "Pa");
            require_within(kelvin, heat, 100, 3000, "K");
            for (size_t k = 0; k < rho.size(); ++k) {
                const double pressure = rho[k];
                const double exner = t ? 1 : std::pow(pressure / reference_pressure, gas_constant_dry / heat_capacity);
                rho[k] = float(pressure / (gas_constant_dry * double(kelvin[k]) * exner));
            }
            say("density of air from '" + p->name + "' and '" + heat.name + "' as of dry air, p / (287.04 T)");
            return rho;
        }
        throw InputError(water_->name + " is water per mass of air [" + unit_text(*water_, options_) +
                         "], and the file has no density of air, nor pressure and temperature: name one with "
                         "--variable density=NAME, or give --air-density");
    }

    /// Models write perturbations under the same names. Values that are missing are not judged.
    static void require_within(const std::vector<float>& values, const NetcdfVariable& variable, double least,
                               double greatest, const char* unit)
    {
        for (const float value : values)
            if (std::isfinite(value) && !(double(value) >= least && double(value) <= greatest))
                throw InputError(variable.name + " = " + shortest(double(value)) + " " + unit + ": expected " +
                                 shortest(least) + " to " + shortest(greatest) +
                                 ". A perturbation? Name the whole with --variable, or give --air-density");
    }

    void to_extinction(const std::vector<float>& water, size_t time)
    {
        const NetcdfVariable* const variable = role("radius");
        const double otherwise = options_.effective_radius > 0 ? options_.effective_radius : usual_radius;
        std::vector<float> radii;
        if (variable) radii = in_units(*variable, {1, 0, 1}, "um or m", time);
        size_t without = 0;
        field_.extinction.resize(water.size());
        for (size_t k = 0; k < water.size(); ++k) {
            const bool known = variable && std::isfinite(radii[k]) && radii[k] > 0;
            without += !known && water[k] > 0;
            const double radius = known ? double(radii[k]) : otherwise;
            field_.extinction[k] = float(1.5 * double(water[k]) / (water_density * radius));
        }
        const std::string taken =
            shortest(otherwise * 1e6) + " um" + (options_.effective_radius > 0 ? "" : ", assumed (--effective-radius)");
        if (variable) say("effective radius from '" + variable->name + "' [" + unit_text(*variable, options_) + "]");
        if (!variable)
            say("effective radius " + taken);
        else if (without > 0)
            say("effective radius " + taken + " in " + std::to_string(without) + " cells with water that have none");
        field_.used_radius = without > 0;
        if (!variable) field_.radius = otherwise;
        say("extinction 3 L / (2 rho_w r) of water drops alone; ice and rain are not in it");
    }

    const CloudFieldOptions& options_;
    NetcdfFile file_;
    const NetcdfVariable *water_ = nullptr, *extinction_ = nullptr;
    NetcdfAxes axes_;
    CloudField field_;
};

/// Refuses what no file of a model holds, in this process: the other one read bytes of a stranger.
void require_sane(const CloudField& field)
{
    constexpr double farthest = 1e9;  // [m]
    for (size_t a = 0; a < 3; ++a) {
        const auto& edges = field.cells.edges[a];
        bool fine = edges.size() >= 2;
        for (size_t k = 0; fine && k < edges.size(); ++k)
            fine = std::abs(edges[k]) <= farthest && (k == 0 || edges[k] > edges[k - 1]);
        if (!fine) throw InputError("coordinates: expected numbers that rise or fall throughout, within 1e9 m");
    }
    if (field.extinction.size() != field.cells.size()) throw InputError("expected a value for each cell");
    for (const float value : field.extinction)
        if (!(value >= 0 && value <= 1e30f))
            throw InputError("extinction " + shortest(double(value)) + " 1/m: expected 0 to 1e30; is a unit wrong?");
}

/// Moves the field onto equal cells.
void make_equal(CloudField& field, const Vec3d& size)
{
    const Cells equal = equal_cells(field.cells, size);
    bool stretched = false, chosen = false;
    for (size_t a = 0; a < 3; ++a) {
        stretched = stretched || !are_equal(field.cells.edges[a]);
        chosen = chosen || size[int(a)] > 0;
    }
    const std::string sizes = shortest(equal.edges[0][1] - equal.edges[0][0]) + " x " +
                              shortest(equal.edges[1][1] - equal.edges[1][0]) + " x " +
                              shortest(equal.edges[2][1] - equal.edges[2][0]) + " m";
    if (stretched || chosen) {
        field.extinction = resampled(field.cells, field.extinction, equal);
        field.said.push_back(std::string(stretched ? "cells of unequal size" : "the field") + " resampled onto " +
                             sizes + "; the optical depth of each column is kept");
    } else {
        field.said.push_back("cells of " + sizes);
    }
    field.cells = equal;
}

void send(ByteChannel& channel, const CloudField& field)
{
    for (const auto& edges : field.cells.edges) channel.put(edges);
    channel.put(field.extinction);
    channel.put(field.said);
    channel.put(
        std::vector<double>{field.water, field.radius, double(field.used_radius), double(field.used_air_density)});
}

CloudField receive(ByteChannel& channel)
{
    CloudField field;
    for (auto& edges : field.cells.edges) edges = channel.get<double>();
    field.extinction = channel.get<float>();
    field.said = channel.get_texts();
    const auto numbers = channel.get<double>();
    if (numbers.size() != 4) throw InputError("the reader of this format ended too early");
    field.water = numbers[0];
    field.radius = numbers[1];
    field.used_radius = numbers[2] != 0;
    field.used_air_density = numbers[3] != 0;
    for (std::string& line : field.said) line = printable(line, 400);
    return field;
}

}  // namespace

size_t cloud_field_times(const std::string& path, const CloudFieldOptions& options)
{
    ByteChannel channel;
    read_guarded(path, [&] { channel.put(std::vector<uint64_t>{Reading(path, options).times()}); });
    return of_file(path, [&] {
        const auto times = channel.get<uint64_t>();
        if (times.size() != 1 || times[0] == 0) throw InputError("no time: expected one or more");
        return size_t(times[0]);
    });
}

CloudField read_cloud_field(const std::string& path, const CloudFieldOptions& options, size_t time)
{
    ByteChannel channel;
    read_guarded(path, [&] { send(channel, Reading(path, options).read(time)); });
    return of_file(path, [&] {
        CloudField field = receive(channel);
        require_sane(field);
        make_equal(field, options.cell);
        return field;
    });
}

}  // namespace vdbcloud
