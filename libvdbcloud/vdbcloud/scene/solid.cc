#include "vdbcloud/scene/solid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/words.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr auto finishes =
    words<Finish>("finish", {{Finish::Diffuse, "diffuse"}, {Finish::Mirror, "mirror"}, {Finish::Glossy, "glossy"}});
constexpr auto kinds = words<SolidKind>("solid", {{SolidKind::Plane, "plane"},
                                                  {SolidKind::Sphere, "sphere"},
                                                  {SolidKind::Box, "box"},
                                                  {SolidKind::LevelSet, "level set"}});

std::string text(const Vec3d& v) { return shortest(v[0]) + "," + shortest(v[1]) + "," + shortest(v[2]); }

bool finite(const Vec3d& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }

void check_reflectance(const char* what, const Vec3d& v)
{
    for (int c = 0; c < 3; ++c)
        if (!(v[c] >= 0 && v[c] <= 1)) throw InputError(std::string(what) + " " + text(v) + ": expected 0 to 1");
}

void check(const Material& m)
{
    check_reflectance("colour of a solid", m.colour);
    if (m.checker) check_reflectance("checker of a solid", *m.checker);
    if (!(m.checker_edge > 0 && std::isfinite(m.checker_edge)))
        throw InputError("edge of a checker " + shortest(m.checker_edge) + ": expected a length above 0");
    if (!(m.roughness >= 0 && m.roughness <= 1))
        throw InputError("roughness " + shortest(m.roughness) + ": expected 0 to 1");
}

void check_level_set(const Solid& s)
{
    if (!s.level_set) throw InputError("a level set without a grid");
    const FloatGrid& grid = *s.level_set;
    const std::string what = "level set '" + printable(grid.getName()) + "'";
    if (!grid.transform().isLinear())
        throw InputError(what + ": its transform is not affine: expected translation, rotation, scale or shear");
    if (!(grid.background() > 0 && std::isfinite(grid.background())))
        throw InputError(what + ": background " + shortest(double(grid.background())) +
                         ": expected a distance above 0, outside");
    for (auto v = grid.cbeginValueAll(); v; ++v)
        if (!std::isfinite(*v)) throw InputError(what + " has a value that is not finite: expected distances");
}

/// Which of a file's solids a grid name stands for: 1 for solid, 2 for solid2; 0 for other names.
long number_of(const std::string& grid_name)
{
    if (!schema::has_role(grid_name, schema::Role::Solid)) return 0;
    const std::string rest = grid_name.substr(std::string(schema::solid).size());
    return rest.empty() ? 1 : std::strtol(rest.c_str(), nullptr, 10);
}

Solid read_solid(const GridBasePtr& grid)
{
    Solid s;
    s.kind = kinds.value(get_text(*grid, schema::solid_kind, kinds.word(SolidKind::LevelSet)));
    s.material.finish = finish_kind(get_text(*grid, schema::solid_finish, finishes.word(Finish::Diffuse)));
    s.material.colour = get_vector(*grid, schema::solid_colour, s.material.colour);
    if (has_meta(*grid, schema::solid_checker))
        s.material.checker = get_vector(*grid, schema::solid_checker, s.material.colour);
    s.material.checker_edge = get_number(*grid, schema::solid_checker_edge, s.material.checker_edge);
    s.material.roughness = get_number(*grid, schema::solid_roughness, s.material.roughness);
    if (s.kind == SolidKind::LevelSet) {
        s.level_set = openvdb::gridPtrCast<FloatGrid>(grid);
        if (!s.level_set)
            throw InputError("grid '" + printable(grid->getName()) + "' of type " + grid->valueType() +
                             ": expected a level set of type float");
    } else {
        s.place = get_vector(*grid, schema::solid_place, s.place);
        s.extent = get_vector(*grid, schema::solid_extent, s.extent);
    }
    check(s);
    return s;
}

GridBasePtr grid_of(const Solid& s)
{
    auto grid = s.kind == SolidKind::LevelSet ? s.level_set->copy() : FloatGrid::create(1.0f);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    set_text(*grid, schema::solid_kind, kinds.word(s.kind));
    if (s.kind != SolidKind::LevelSet) {
        set_vector(*grid, schema::solid_place, s.place);
        set_vector(*grid, schema::solid_extent, s.extent);
    }
    const Material& m = s.material;
    set_text(*grid, schema::solid_finish, finishes.word(m.finish));
    set_vector(*grid, schema::solid_colour, m.colour);
    for (const char* key : {schema::solid_checker, schema::solid_checker_edge, schema::solid_roughness})
        grid->removeMeta(key);
    if (m.checker) {
        set_vector(*grid, schema::solid_checker, *m.checker);
        set_number(*grid, schema::solid_checker_edge, m.checker_edge);
    }
    if (m.finish == Finish::Glossy) set_number(*grid, schema::solid_roughness, m.roughness);
    return grid;
}

std::string shape_text(const Solid& s)
{
    if (s.kind == SolidKind::LevelSet) return grid_digest(*s.level_set);
    return std::string(kinds.word(s.kind)) + " " + text(s.place) + " " + text(s.extent);
}

std::string material_text(const Material& m)
{
    std::string out = std::string(name(m.finish)) + " " + text(m.colour);
    if (m.checker) out += " " + text(*m.checker) + " " + shortest(m.checker_edge);
    if (m.finish == Finish::Glossy) out += " " + shortest(m.roughness);
    return out;
}

}  // namespace

const char* name(Finish finish) { return finishes.word(finish); }

Finish finish_kind(const std::string& word) { return finishes.value(word); }

const Vec3d& Material::reflectance(const Vec3d& x) const
{
    if (!checker) return colour;
    double cubes = 0;
    for (int a = 0; a < 3; ++a) cubes += std::floor(x[a] / checker_edge);
    return std::fmod(std::abs(cubes), 2.0) < 0.5 ? colour : *checker;
}

bool Material::black() const { return colour == Vec3d(0.0) && (!checker || *checker == Vec3d(0.0)); }

bool operator==(const Material& p, const Material& q) { return material_text(p) == material_text(q); }

Solid make_plane(const Vec3d& point, const Vec3d& up, const Material& material)
{
    if (!(up.length() > 0) || !finite(up)) throw InputError("up of a plane " + text(up) + ": expected a direction");
    return {SolidKind::Plane, point, up.unit(), nullptr, material};
}

Solid make_ball(const Vec3d& middle, double radius, const Material& material)
{
    return {SolidKind::Sphere, middle, Vec3d(radius), nullptr, material};
}

Solid make_box(const Vec3d& lowest, const Vec3d& highest, const Material& material)
{
    return {SolidKind::Box, lowest, highest, nullptr, material};
}

Solid make_level_set(FloatGridPtr grid, const Material& material)
{
    return {SolidKind::LevelSet, {}, {}, std::move(grid), material};
}

void check(const Solid& s)
{
    check(s.material);
    if (s.kind == SolidKind::LevelSet) return check_level_set(s);
    if (!finite(s.place) || !finite(s.extent)) throw InputError(described(s) + ": expected finite numbers");
    if (s.kind == SolidKind::Plane && std::abs(s.extent.length() - 1) > 1e-9)
        throw InputError(described(s) + ": expected a normal of length 1");
    if (s.kind == SolidKind::Sphere && !(s.extent[0] > 0))
        throw InputError(described(s) + ": expected a radius above 0");
    for (int a = 0; a < 3 && s.kind == SolidKind::Box; ++a)
        if (!(s.extent[a] > s.place[a]))
            throw InputError(described(s) + ": expected a second corner above the first along x, y and z");
}

std::string described(const Solid& s)
{
    switch (s.kind) {
    case SolidKind::Plane: return "plane at " + text(s.place) + " up " + text(s.extent);
    case SolidKind::Sphere: return "sphere at " + text(s.place) + " of radius " + shortest(s.extent[0]);
    case SolidKind::Box: return "box from " + text(s.place) + " to " + text(s.extent);
    case SolidKind::LevelSet: break;
    }
    return "level set '" + printable(s.level_set ? s.level_set->getName() : "") + "'";
}

double bytes_of(const std::vector<Solid>& solids)
{
    double bytes = 0;
    for (const Solid& solid : solids)
        if (solid.level_set) bytes += double(solid.level_set->memUsage());
    return bytes;
}

std::vector<Vec3d> corners_of(const Solid& s)
{
    std::vector<Vec3d> out;
    if (s.kind == SolidKind::Plane) return out;
    Vec3d low = s.place, high = s.extent;
    if (s.kind == SolidKind::Sphere) low = s.place - s.extent, high = s.place + s.extent;
    if (s.kind == SolidKind::LevelSet) {
        openvdb::CoordBBox box;
        for (auto v = s.level_set->cbeginValueAll(); v; ++v) {
            if (!(*v < 0)) continue;
            openvdb::CoordBBox voxels;
            v.getBoundingBox(voxels);
            box.expand(voxels);
        }
        if (box.empty()) return out;
        low = box.min().asVec3d() - Vec3d(1);
        high = box.max().asVec3d() + Vec3d(1);
    }
    for (int k = 0; k < 8; ++k) {
        const Vec3d corner((k & 1 ? high : low)[0], (k & 2 ? high : low)[1], (k & 4 ? high : low)[2]);
        out.push_back(s.kind == SolidKind::LevelSet ? s.level_set->indexToWorld(corner) : corner);
    }
    return out;
}

std::vector<Solid> solids_of(const GridFile& file)
{
    std::vector<std::pair<long, GridBasePtr>> found;
    for (const GridBasePtr& grid : file.grids)
        if (const long number = number_of(grid->getName())) found.emplace_back(number, grid);
    std::stable_sort(found.begin(), found.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
    std::vector<Solid> solids;
    for (const auto& [number, grid] : found) solids.push_back(read_solid(grid));
    return solids;
}

void put_solids(GridFile& file, const std::vector<Solid>& solids)
{
    std::vector<GridBasePtr> grids;
    for (const Solid& s : solids) {
        grids.push_back(grid_of(s));
        grids.back()->setName(schema::solid + (grids.size() > 1 ? std::to_string(grids.size()) : std::string()));
    }
    remove_grids(file, [](const std::string& name) { return schema::has_role(name, schema::Role::Solid); });
    for (const GridBasePtr& grid : grids) file.grids.push_back(grid);
}

std::string solids_digest(const std::vector<Solid>& solids, bool materials)
{
    std::vector<std::string> lines;
    for (const Solid& s : solids) lines.push_back(shape_text(s) + (materials ? " " + material_text(s.material) : ""));
    if (lines.empty()) return "";
    std::sort(lines.begin(), lines.end());
    Digest digest;
    for (const std::string& line : lines) digest.add_text(line);
    return digest.hex();
}

}  // namespace vdbcloud
