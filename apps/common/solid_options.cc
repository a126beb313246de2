#include "solid_options.h"

#include "inputs.h"
#include "nearest.h"
#include "option_words.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>

namespace vdbcloud::app {

namespace {

Material material_of(OptionWords& words, std::vector<std::string>& known, const Material& otherwise)
{
    Material m = otherwise;
    int finishes = 0;
    for (const Finish finish : {Finish::Diffuse, Finish::Mirror, Finish::Glossy})
        if (words.has(name(finish))) {
            m.finish = finish;
            ++finishes;
        }
    if (finishes > 1) words.refuse("expected one of diffuse, mirror and glossy");
    m.colour = words.colour("colour", m.colour);
    known.insert(known.end(), {"diffuse", "mirror", "glossy", "colour=r,g,b", "checker=r,g,b"});
    if (const Vec3d second = words.colour("checker", Vec3d(-1.0)); second[0] >= 0) {
        m.checker = second;
        m.checker_edge = words.size("edge", m.checker_edge);
        known.push_back("edge=LENGTH");
    }
    if (m.finish == Finish::Glossy) {
        m.roughness = words.size("roughness", m.roughness);
        known.push_back("roughness=0..1");
    }
    return m;
}

std::vector<Solid> solids_of_file(App& app, const std::string& path)
{
    const GridFile file = app.read(path);
    return of_file(file.path, [&] {
        std::vector<Solid> solids = solids_of(file);
        if (solids.empty())
            for (const GridBasePtr& grid : file.grids)
                if (grid->getGridClass() == openvdb::GRID_LEVEL_SET && grid->isType<FloatGrid>())
                    solids.push_back(make_level_set(openvdb::gridPtrCast<FloatGrid>(grid)));
        if (solids.empty()) throw InputError("expected a level set of floats, and the file has " + grid_list(file));
        for (const Solid& solid : solids) check(solid);
        return solids;
    });
}

std::vector<Solid> parsed(App& app, const std::string& text, const Vec3d& up)
{
    OptionWords words("--solid", text);
    std::vector<std::string> known;
    std::vector<Solid> solids;
    const auto made = [&](Solid solid) {
        solid.material = material_of(words, known, {});
        words.finish(known);
        try {
            check(solid);
        } catch (const InputError& e) {
            words.refuse(e.what());
        }
        solids.push_back(std::move(solid));
        return solids;
    };
    if (const auto solid = plain_solid(words, up, known)) return made(*solid);
    const auto ends = [&](const std::string& end) {
        return words.shape.size() >= end.size() &&
               words.shape.compare(words.shape.size() - end.size(), end.size(), end) == 0;
    };
    if (!ends(".vdb")) words.refuse("'" + words.shape + "': expected plane, sphere, box, or the path of a .vdb");
    solids = solids_of_file(app, words.shape);
    for (Solid& solid : solids) {
        OptionWords again("--solid", text);
        solid.material = material_of(again, known, solid.material);
        again.finish(known);
    }
    return solids;
}

}  // namespace

std::optional<Solid> plain_solid(OptionWords& words, const Vec3d& up, std::vector<std::string>& known)
{
    if (words.shape == "plane") {
        known = {"at=x,y,z", "up=x,y,z"};
        const Vec3d at = words.place("at", Vec3d(0.0)), normal = words.place("up", up);
        if (!(normal.length() > 0)) words.refuse("'up': expected a direction");
        return make_plane(at, normal);
    }
    if (words.shape == "sphere") {
        known = {"at=x,y,z", "radius=LENGTH"};
        const Vec3d at = words.place("at", Vec3d(0.0));
        return make_ball(at, words.size("radius", std::nullopt));
    }
    if (words.shape == "box") {
        known = {"from=x,y,z", "to=x,y,z"};
        const Vec3d from = words.place("from", std::nullopt);
        return make_box(from, words.place("to", std::nullopt));
    }
    return std::nullopt;
}

void declare_solids(App& app, SolidOptions& o, const std::string& group)
{
    o.option =
        app.add_option(
               "--solid", o.asked,
               "an opaque body beside the medium; repeat for another. A shape: 'plane; at=x,y,z; up=x,y,z' (all "
               "below a plane without end), 'sphere; at=x,y,z; radius=R', 'box; from=x,y,z; to=x,y,z', or a .vdb "
               "with level sets, such as fractalgen --mountain writes. Then its material: diffuse, mirror or "
               "'glossy; roughness=0..1', colour=r,g,b, and 'checker=r,g,b; edge=LENGTH' for a second colour. "
               "Without it the solids of the file")
            .scene("solids")
            .type_name("SOLID")
            .group(group);
}

std::vector<Solid> chosen_solids(App& app, const SolidOptions& o, const std::vector<const GridFile*>& files,
                                 const Vec3d& up)
{
    std::vector<Solid> solids;
    for (const std::string& text : o.asked)
        for (Solid& solid : parsed(app, text, up)) solids.push_back(std::move(solid));
    if (!o.asked.empty()) return solids;
    for (const GridFile* file : files)
        for (Solid& solid : of_file(file->path, [&] { return solids_of(*file); })) solids.push_back(std::move(solid));
    return solids;
}

}  // namespace vdbcloud::app
