#include "inputs.h"

#include "light_options.h"
#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/scene/solid.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbcloud::app {

namespace {

/// The entries on which all maps that have them agree.
MetaMap agreed(const std::vector<const MetaMap*>& maps)
{
    MetaMap out;
    std::set<std::string> contradicted;
    for (const MetaMap* map : maps)
        for (auto entry = map->beginMeta(); entry != map->endMeta(); ++entry) {
            const auto earlier = out[entry->first];
            if (!earlier)
                out.insertMeta(entry->first, *entry->second);
            else if (*earlier != *entry->second)
                contradicted.insert(entry->first);
        }
    for (const std::string& key : contradicted) out.removeMeta(key);
    return out;
}

/// True for a grid that takes part in the joined medium, or that the stage makes again for the joined medium.
bool is_replaced(const std::string& name, const std::string& density)
{
    return name == density || schema::has_role(name, schema::Role::Colour) ||
           schema::has_role(name, schema::Role::Emission) || schema::has_role(name, schema::Role::Transmittance) ||
           schema::has_role(name, schema::Role::Solid);
}

void tell_dropped(App& app, const std::vector<GridFile>& files, const std::vector<MediumPart>& parts)
{
    std::set<std::string> dropped;
    for (size_t n = 0; n < files.size(); ++n)
        for (const auto& grid : files[n].grids)
            if (!is_replaced(grid->getName(), parts[n].density->getName())) dropped.insert(printable(grid->getName()));
    if (dropped.empty()) return;
    std::string names;
    for (const std::string& name : dropped) names += (names.empty() ? "" : ", ") + name;
    app.say("grids that belong to one input alone are not written: " + names);
}

void tell_resampled(App& app, const JoinedMedium& joined)
{
    for (const ResampledPart& part : joined.resampled)
        app.say(part.name + ": density sampled on the voxels of the finest input; its optical mass, " +
                brief(std::abs(100 * (1 - part.correction))) + " % off by sampling, is restored");
}

std::shared_ptr<MetaMap> file_metadata(const std::vector<GridFile>& files, const std::string& density)
{
    std::vector<const MetaMap*> maps;
    std::string history;
    bool chosen = false;
    for (const GridFile& file : files) {
        maps.push_back(file.metadata.get());
        chosen = chosen || has_meta(*file.metadata, schema::density_choice);
        const std::string lines = get_text(*file.metadata, schema::history, "");
        if (!lines.empty()) history += (history.empty() || history.back() == '\n' ? "" : "\n") + lines;
    }
    auto metadata = std::make_shared<MetaMap>(agreed(maps));
    if (!history.empty()) set_text(*metadata, schema::history, history);
    if (chosen) set_text(*metadata, schema::density_choice, density);
    return metadata;
}

/// Metadata of the joined density: what the densities agree on, and the coefficients of the joined medium.
void describe(FloatGrid& density, const std::vector<MediumPart>& parts, const Medium& medium)
{
    const std::string name = density.getName();
    std::vector<const MetaMap*> maps;
    bool given = true;
    for (const MediumPart& part : parts) {
        if (!has_matter(*part.density)) continue;
        maps.push_back(part.density.get());
        given = given && get_text(*part.density, schema::sigma_t_origin, "given") == "given";
    }
    const MetaMap common = agreed(maps);
    for (auto entry = common.beginMeta(); entry != common.endMeta(); ++entry)
        if (entry->first.rfind("file_", 0) != 0) density.insertMeta(entry->first, *entry->second);
    write_medium(density, medium);
    set_text(density, schema::sigma_t_origin, given ? "given" : "automatic");
    density.setName(name);
    density.setGridClass(openvdb::GRID_FOG_VOLUME);
}

/// The box of the joined density, of which each part gets the corners: media that repeat have one period.
void widen(FloatGrid& part, const FloatGrid& joined)
{
    const openvdb::CoordBBox box = joined.evalActiveVoxelBoundingBox();
    if (box.empty()) return;
    for (const openvdb::Coord& corner : {box.min(), box.max()}) part.tree().setActiveState(corner, true);
}

/// Puts the media that overlap, each with its coefficients: density, medium_2, ...; Cd, Cd_2, ...
void put_parts(JoinedMedium& joined, const std::vector<MediumPart>& given, bool repeats, GridFile& file)
{
    for (size_t n = 0; n < joined.parts.size(); ++n) {
        MediumPart& part = joined.parts[n];
        const std::string number = std::to_string(n + 1);
        part.density->setName(n == 0 ? joined.density->getName() : schema::medium_prefix + number);
        const auto of = std::find_if(given.begin(), given.end(), [&](const auto& p) { return p.name == part.name; });
        describe(*part.density, {*of}, part.medium);
        if (repeats) widen(*part.density, *joined.density);
        file.grids.push_back(part.density);
        if (!part.colour) continue;
        part.colour = part.colour->deepCopy();
        part.colour->setName(n == 0 ? schema::colour : schema::medium_colour_prefix + number);
        file.grids.push_back(part.colour);
    }
    set_number(*file.metadata, schema::media, double(joined.parts.size()));
}

/// The media of a file, each with its density and Cd; the first keeps all other grids.
std::vector<GridFile> media_of(GridFile file)
{
    const int count = int(get_number(*file.metadata, schema::media, 1));
    file.metadata->removeMeta(schema::media);
    std::vector<GridFile> media;
    for (int n = 2; n <= count; ++n) {
        const std::string name = schema::medium_prefix + std::to_string(n);
        GridFile& own = media.emplace_back();
        own.path = file.path;
        own.metadata = std::make_shared<MetaMap>(*file.metadata);
        own.metadata->removeMeta(schema::history);
        set_text(*own.metadata, schema::density_choice, name);
        const GridBasePtr density = find_grid(file, name);
        if (!density)
            throw InputError(file.path + ": grid '" + name + "' is missing: expected " + std::to_string(count) +
                             " media; run p1solve again");
        own.grids.push_back(density);
        if (const GridBasePtr colour = find_grid(file, schema::medium_colour_prefix + std::to_string(n))) {
            own.grids.push_back(colour->copyGrid());
            own.grids.back()->setName(schema::colour);
        }
    }
    if (count > 1)
        remove_grids(file, [](const std::string& name) {
            return name.rfind(schema::medium_prefix, 0) == 0 || name.rfind(schema::medium_colour_prefix, 0) == 0;
        });
    media.insert(media.begin(), std::move(file));
    return media;
}

GridFile joined_file(App& app, const std::vector<GridFile>& files, const std::vector<MediumPart>& parts,
                     bool may_overlap, MediumInput& out)
{
    JoinedMedium joined = joined_medium(parts, may_overlap);
    tell_resampled(app, joined);
    tell_dropped(app, files, parts);
    GridFile file;
    file.path = files.front().path;
    for (size_t n = 1; n < files.size(); ++n)
        if (!is_further_medium(files[n])) file.path += " " + files[n].path;
    file.metadata = file_metadata(files, joined.density->getName());
    if (joined.parts.empty()) {
        describe(*joined.density, parts, joined.medium);
        file.grids = {joined.density};
        if (joined.colour) file.grids.push_back(joined.colour);
    } else {
        put_parts(joined, parts, out.periodic != Axes{}, file);
        app.say(std::to_string(joined.parts.size()) + " media overlap; each keeps its phase function and its colours");
    }
    if (joined.emission) file.grids.push_back(joined.emission);
    std::vector<Solid> solids;
    for (const GridFile& each : files)
        for (Solid& solid : of_file(each.path, [&] { return solids_of(each); })) solids.push_back(std::move(solid));
    put_solids(file, solids);
    out.density = joined.density;
    out.medium = joined.medium;
    out.parts = joined.parts;
    return file;
}

}  // namespace

World::World(bool compare_up) : compare_up_(compare_up), said_(std::make_shared<MetaMap>()) {}

void World::Fact::require(const std::string& file, const std::string& value)
{
    if (value.empty()) return;
    if (value_.empty()) {
        file_ = file;
        value_ = value;
    } else if (value != value_) {
        throw UsageError(printable(file_, 4096) + " has " + what_ + " " + value_ + " and " + printable(file, 4096) +
                         " has " + what_ + " " + value + ": " + way_out_);
    }
}

void World::add(const std::string& file, const MetaMap& metadata)
{
    const auto axis = read_up_axis(metadata);
    if (axis && compare_up_) up_.require(file, up_axis_words.word(*axis));
    const double metres = get_number(metadata, schema::meters_per_unit, 0);
    if (metres > 0) unit_.require(file, shortest(metres));
    const auto take = [&](const char* key, bool says) {
        if (says && !(*said_)[key]) said_->insertMeta(key, *metadata[key]);
    };
    take(schema::up_axis, axis.has_value());
    take(schema::meters_per_unit, metres > 0);
}

void World::complete(MetaMap& metadata) const
{
    for (auto said = said_->beginMeta(); said != said_->endMeta(); ++said)
        if (!metadata[said->first]) metadata.insertMeta(said->first, *said->second);
}

std::vector<GridFile> read_inputs(App& app, const std::vector<std::string>& paths, const std::string& density,
                                  bool compare_up)
{
    std::vector<GridFile> files;
    World world(compare_up);
    for (const std::string& path : paths) {
        GridFile file = app.read(path);
        world.add(path, *file.metadata);
        if (!density.empty()) {
            files.push_back(std::move(file));
            continue;
        }
        for (GridFile& medium : of_file(path, [&] { return media_of(std::move(file)); }))
            files.push_back(std::move(medium));
    }
    return files;
}

bool is_further_medium(const GridFile& file)
{
    return get_text(*file.metadata, schema::density_choice, "").rfind(schema::medium_prefix, 0) == 0;
}

std::vector<LightsOfInput> lights_found(const std::vector<GridFile>& files)
{
    std::vector<LightsOfInput> found;
    for (const GridFile& file : files)
        found.push_back({file.path, of_file(file.path, [&] { return lights_of(file); })});
    return found;
}

std::vector<Light> inherited_lights(const std::vector<LightsOfInput>& inputs, const std::vector<Light>& asked)
{
    std::vector<Light> lights;
    const auto name_taken = [&](const std::string& name) {
        return std::any_of(lights.begin(), lights.end(), [&](const Light& l) { return l.name == name; });
    };
    for (const auto& [file, of_input] : inputs) {
        std::vector<Light> here;
        std::vector<bool> unmatched(lights.size(), true);  // of `lights`, by those of this input
        for (const Light& light : of_input) {
            const auto replaces = [&light](const Light& a) { return a.name == light.name || same_light(a, light); };
            if (std::any_of(asked.begin(), asked.end(), replaces)) continue;
            size_t known = 0;
            while (known < unmatched.size() && !(unmatched[known] && same_light(lights[known], light))) ++known;
            if (known < unmatched.size())
                unmatched[known] = false;
            else
                here.push_back(light);
        }
        // Two inputs of which each has a light of one name that the other has not contradict each other.
        for (Light& light : here) {
            for (size_t k = 0; k < unmatched.size(); ++k)
                if (unmatched[k] && lights[k].name == light.name)
                    throw UsageError(file + ": '" + lights_text({light}) + "' is not the '" + lights_text({lights[k]}) +
                                     "' of another input: choose with --sun or --lamp");
            const std::string base = light.name;
            for (int n = 2; name_taken(light.name); ++n) light.name = base + "_" + std::to_string(n);
            lights.push_back(light);
        }
    }
    return lights;
}

MediumInput read_one_medium(App& app, const StageOptions& o, const MediumOptions& options, bool may_overlap)
{
    std::vector<GridFile> files = read_inputs(app, o.inputs, o.density, !o.up);
    MediumInput out;
    out.periodic = periodic_axes(o.periodic, files);
    check_fire(options.fire, files);
    std::vector<MediumPart> parts;
    for (GridFile& file : files)
        parts.push_back(of_file(file.path, [&] {
            MediumPart part;
            part.name = file.path;
            if (is_further_medium(file)) part.name += " " + get_text(*file.metadata, schema::density_choice, "");
            part.density = density_of(file, o.density, app.warnings());
            const Fire fire = fire_of(app, file, options.fire);
            part.medium = chosen_medium(app, options, *part.density, fire.heat());
            if (files.size() > 1) {
                part.colour = vector_grid(app, file, grid_of(file, schema::colour));
                part.emission = emission_of(app, file, fire, *part.density, part.medium, part.colour.get());
            } else {
                out.fire = fire;
            }
            return part;
        }));
    out.lights = lights_found(files);
    if (files.size() == 1) {
        out.density = parts[0].density;
        out.medium = parts[0].medium;
        out.file = std::move(files[0]);
    } else {
        out.file = joined_file(app, files, parts, may_overlap, out);
    }
    return out;
}

}  // namespace vdbcloud::app
