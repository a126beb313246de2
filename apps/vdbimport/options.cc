#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/exchange/particles.h"

#include <algorithm>

namespace vdbcloud {

namespace {

void declare_files(app::App& app, Options& o)
{
    app.writes_grids();
    app.takes_frames(false);
    app.add_option(
           "input", o.input,
           "the file to read: a table of numbers (- for standard input), a field of a cloud model in netCDF, an array "
           "(.npy, .raw), a property file of SHDOM (.prp), particles (.ply, .csv with a line of names, points in a "
           ".vdb), or grids of NanoVDB. A table is a vertical section whose rows are layers, the top one first; "
           "with --thickness a map of columns; with --boxes a list of boxes")
        ->required()
        ->type_name("FILE")
        ->reads_files();
    o.option.output =
        app.add_option(
               "-o,--output", o.output,
               "the cloud to write: a .vdb, or - for standard output. For several times of a netCDF file a name "
               "with a place for a number, as cloud.%04d.vdb")
            ->required()
            ->type_name("FILE")
            ->writes_frames(app::FileKind::Grids);
    app.add_choice<Format>("--format", o.format, format_words(),
                           "kind of the input; auto: by its first bytes, else by its extension, else a table");
    o.option.cell =
        app.add_option(
               "--cell", o.cell,
               "DX,DY,DZ: size of a cell. Of a table along a row (x), across, and vertically [world unit]; tables "
               "of the I3RC are in metres. Of an array along x, y, z [world unit]; default: 1. Of particles, size "
               "of a voxel [world unit]; default: half the median radius. Of netCDF [m] and .prp, cells of the "
               "grid, onto which the field is resampled; default: the file's, and where these are unequal the "
               "smallest one")
            ->default_str("")
            ->not_with([&o] { return o.is(Format::NanoVdb); }, "NanoVDB")
            ->check(app::positive);
    app.add_choice<std::optional<UpAxis>>(
           "--up", o.up, app::up_axis_choices<std::optional<UpAxis>>(),
           "axis that points up; default: z of netCDF and .prp, else y. With y, x, y, z of "
           "netCDF and .prp become x, -z, y")
        ->scene("medium");
    app.add_option("--meters-per-unit", o.meters_per_unit,
                   "metres of a world unit, written into the file; a field in netCDF, which is in metres, is scaled. "
                   "Default: 1 of netCDF, 1000 of .prp; other files say nothing")
        ->default_str("")
        ->check(app::within(1e-6, 1e6));
}

void declare_tables(app::App& app, Options& o)
{
    const auto boxes = [&o] { return o.boxes; };
    const auto table = [&o] { return o.is(Format::Table); };
    app.add_flag("--boxes", o.boxes,
                 "a row of the table is a box: x0 y0 z0 x1 y1 z1 [world unit], extinction [1/world unit], and emission "
                 "[radiance/world unit] where there is an eighth number. A voxel has the values of the last box that "
                 "holds its centre")
        .only_with(table, "a table")
        .group("Tables");
    app.add_choice<Values>(
           "--values", o.values, {{"optical-depth", Values::OpticalDepth}, {"extinction", Values::Extinction}},
           "what a number of the table is: optical depth of a cell from top to base, or of a whole column "
           "with --thickness; or extinction [1/world unit]")
        .only_with(table, "a table")
        .not_with(boxes, "--boxes")
        .group("Tables");
    const app::Option thickness =
        app.add_option("--thickness", o.thickness, "a table of the same shape: geometric thickness of each column")
            .only_with(table, "a table")
            .not_with(boxes, "--boxes")
            .group("Tables");
    thickness->type_name("FILE")->reads_files();
    app.add_option("--thickness-unit", o.thickness_unit, "world units in a unit of --thickness: 1000 for km and m")
        ->check(app::positive)
        ->needs(thickness)
        .group("Tables");
    app.add_option("--across", o.across, "cells across a section, which are all alike")
        ->check(app::within(1, 4096))
        ->only_with(table, "a table")
        ->not_with([&o] { return !o.thickness.empty(); }, "--thickness")
        ->not_with(boxes, "--boxes")
        .group("Tables");
    app.add_option("--base", o.base, "height of the cloud's base [world unit]")
        .only_with(table, "a table")
        .not_with(boxes, "--boxes")
        .group("Tables");
}

void declare_fields(app::App& app, Options& o)
{
    const auto netcdf = [&o] { return o.is(Format::NetCdf); };
    const char* const wanted = "a netCDF file";
    app.add_option(
           "--unit", o.units,
           "NAME=UNIT: the unit of a variable, in place of its attribute units: g/kg, kg m-3, km, um; again for "
           "a further variable")
        .only_with(netcdf, wanted)
        .group("Fields of models");
    o.option.effective_radius =
        app.add_option("--effective-radius", o.effective_radius,
                       "effective radius of the droplets [um] where the file has none; default: 10")
            ->default_str("")
            ->check(app::within(0.1, 1000))
            .only_with(netcdf, wanted)
            .group("Fields of models");
    o.option.air_density =
        app.add_option(
               "--air-density", o.air_density,
               "density of air [kg/m^3] for water per mass of air, where the file has no density; in place of the "
               "file's pressure and temperature")
            ->default_str("")
            ->check(app::within(1e-6, 100))
            .only_with(netcdf, wanted)
            .group("Fields of models");
    o.option.times =
        app.add_option("--times", o.times,
                       "times of the file, counted from 0: 3, 0-10, or 0-10x2 for each second; default: all. "
                       "Each goes to the frame of its number")
            .only_with(netcdf, wanted)
            .group("Fields of models");
}

/// One of the words for a number's type, of ArrayLayout.
CLI::Validator type_word()
{
    return {[](const std::string& word) {
                return bytes_of_type(word) > 0
                           ? std::string()
                           : "'" + printable(word, 40) + "': expected u1 u2 u4 i1 i2 i4 f2 f4 or f8";
            },
            ""};
}

CLI::Validator axis_order()
{
    return {[](const std::string& word) {
                std::string sorted = word;
                std::sort(sorted.begin(), sorted.end());
                return sorted == "xyz" ? std::string() : "'" + printable(word, 40) + "': expected xyz in some order";
            },
            ""};
}

void declare_arrays(app::App& app, Options& o)
{
    const auto raw = [&o] { return o.is(Format::Raw); };
    const auto array = [&o] { return o.is(Format::Raw) || o.is(Format::Npy); };
    app.add_option("--shape", o.shape, "NX,NY,NZ: numbers of a raw array along x, y and z")
        .default_str("")
        .check(app::positive)
        .only_with(raw, "a raw array")
        .group("Arrays");
    app.add_option("--type", o.type,
                   "numbers of a raw array: u1 u2 u4 u8 whole, i1 i2 i4 i8 whole with a sign, f2 f4 f8 floating-point, "
                   "with their bytes")
        .check(type_word())
        .only_with(raw, "a raw array")
        .group("Arrays");
    app.add_flag("--big-endian", o.big_endian, "a raw array has the highest byte of a number first")
        .only_with(raw, "a raw array")
        .group("Arrays");
    app.add_option(
           "--axes", o.axes,
           "axes of an array from the slowest to the fastest, which of a .npy are its indices from the first to "
           "the last: zyx has x beside x in the file")
        .check(axis_order())
        .only_with(array, "a .npy or raw array")
        .group("Arrays");
}

std::string listed(const std::vector<std::string>& words)
{
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
}

void declare_particles(app::App& app, Options& o)
{
    o.option.radius = app.add_option("--radius", o.radius,
                                     "radius of the particles [world unit] where they have none of their own; without "
                                     "it each goes to the eight nearest voxels")
                          ->default_str("")
                          ->check(app::positive)
                          .only_with([&o] { return o.particles(); }, "particles")
                          .group("Particles");
    app.add_option(
           "--variable", o.variables,
           "ROLE=NAME: the variable of netCDF, or the column or attribute of particles, that has a role; again for "
           "a further role. Roles of netCDF: " +
               listed(cloud_field_roles()) +
               "; by default found by CF standard_name and axis, else by common "
               "names (qc, ql, LWC, reff, ...). Roles of particles: " +
               listed(particle_roles()) + "; by default found by common names (x, Px, P[0], pscale, vx, ...)")
        .only_with([&o] { return o.particles() || o.is(Format::NetCdf); }, "netCDF or particles");
}

}  // namespace

std::map<std::string, std::string> pairs_of(const std::string& option, const std::vector<std::string>& words)
{
    std::map<std::string, std::string> pairs;
    for (const std::string& word : words) {
        const size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
            throw UsageError(option + " " + printable(word) + ": expected two words with = between");
        if (!pairs.emplace(word.substr(0, equals), word.substr(equals + 1)).second)
            throw UsageError(option + " " + printable(word) + ": " + printable(word.substr(0, equals)) +
                             " comes twice");
    }
    return pairs;
}

void declare(app::App& app, Options& o)
{
    declare_files(app, o);
    declare_tables(app, o);
    declare_fields(app, o);
    declare_arrays(app, o);
    declare_particles(app, o);
    app::declare_medium(app, o.medium, app::MediumSource::None);
    app.examples(
        {{"a section of two columns and three layers, rendered",
          "printf '0 1\\n2 4\\n2 2\\n' > section.txt && vdbimport section.txt --cell 50,50,45 --across 4 -o "
          "section.vdb && "
          "render section.vdb --resolution 64 -o section.png"},
         {"a map of two columns of optical depth, 0.2 and 0.3 km thick",
          "printf '5 8\\n' > depth.txt && printf '0.2 0.3\\n' > km.txt && vdbimport depth.txt --thickness km.txt "
          "--thickness-unit 1000 --cell 30,30,30 -o columns.vdb"},
         {"two particles of smoke, of radius 1 and 0.5, splatted",
          "printf 'x,y,z,radius\\n0,0,0,1\\n1,1,0,0.5\\n' > smoke.csv && vdbimport smoke.csv -o smoke.vdb && "
          "render smoke.vdb --resolution 64 -o smoke.png"}});
}

}  // namespace vdbcloud
