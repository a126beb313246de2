#include "vdbcloud/exchange/usd.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"

#include <filesystem>
#include <map>
#include <set>

namespace vdbcloud {

namespace {

bool is_vector(const GridBase& grid) { return grid.isType<Vec3SGrid>(); }
bool is_field(const GridBase& grid) { return grid.isType<FloatGrid>() || is_vector(grid); }

const char* class_of(const GridBase& grid)
{
    switch (grid.getGridClass()) {
    case openvdb::GRID_LEVEL_SET: return "levelSet";
    case openvdb::GRID_FOG_VOLUME: return "fogVolume";
    case openvdb::GRID_STAGGERED: return "staggered";
    default: return "unknown";
    }
}

const char* hint_of(const GridBase& grid)
{
    if (!is_vector(grid)) return "None";
    using schema::Role;
    const bool vector =
        schema::has_role(grid.getName(), Role::Velocity) || schema::has_role(grid.getName(), Role::Flux);
    return vector ? "Vector" : "Color";
}

/// Letters, digits and '_', not a digit first; each name once.
std::string prim_name(const std::string& name, std::set<std::string>& taken)
{
    std::string prim = name.empty() || (name[0] >= '0' && name[0] <= '9') ? "_" : "";
    for (const char c : name) prim += (std::isalnum(static_cast<unsigned char>(c)) != 0 && c > 0) ? c : '_';
    std::string unique = prim;
    for (int k = 1; !taken.insert(unique).second; ++k) unique = prim + "_" + std::to_string(k);
    return unique;
}

/// Text between quotes.
std::string quoted(const std::string& text)
{
    std::string all = "\"";
    for (const char c : text)
        if (c == '"' || c == '\\')
            all += std::string("\\") + c;
        else
            all += c;
    return all + "\"";
}

std::string point(const Vec3d& p) { return "(" + shortest(p[0]) + ", " + shortest(p[1]) + ", " + shortest(p[2]) + ")"; }

/// The box of the voxels of all fields, whose faces are half a voxel beyond the outermost centres.
std::string extent_of(const GridFile& file)
{
    openvdb::BBoxd all;
    for (const GridBasePtr& grid : file.grids) {
        openvdb::CoordBBox box;
        if (!is_field(*grid) || !grid->baseTree().evalActiveVoxelBoundingBox(box)) continue;
        const openvdb::BBoxd index(box.min().asVec3d() - Vec3d(0.5), box.max().asVec3d() + Vec3d(0.5));
        all.expand(grid->transform().indexToWorld(index));
    }
    if (all.empty()) return {};
    return "    float3[] extent = [" + point(all.min()) + ", " + point(all.max()) + "]\n";
}

}  // namespace

std::string usda_text(const GridFile& file, const std::string& asset)
{
    if (asset.find('@') != std::string::npos)
        throw InputError(asset + ": expected a name without @, which ends a path in USD");
    const auto up = read_up_axis(*file.metadata);
    std::string fields, prims;
    std::set<std::string> taken;
    std::map<std::string, int> index;  // among grids of one name
    for (const GridBasePtr& grid : file.grids) {
        const std::string& name = grid->getName();
        const int number = index[name]++;
        if (!is_field(*grid)) continue;
        const std::string prim = prim_name(name, taken);
        fields += "    rel field:" + prim + " = </volume/" + prim + ">\n";
        prims += "\n    def OpenVDBAsset \"" + prim + "\"\n    {\n        asset filePath = @" + asset +
                 "@\n        token fieldName = " + quoted(name) +
                 "\n        int fieldIndex = " + std::to_string(number) + "\n        token fieldDataType = \"" +
                 (is_vector(*grid) ? "float3" : "float") + "\"\n        token fieldClass = \"" + class_of(*grid) +
                 "\"\n        token vectorDataRoleHint = \"" + hint_of(*grid) + "\"\n    }\n";
    }
    if (fields.empty()) throw InputError(printable(file.path) + ": no grid of float or vec3s");
    return "#usda 1.0\n(\n    defaultPrim = \"volume\"\n    metersPerUnit = " +
           shortest(get_number(*file.metadata, schema::meters_per_unit, 1)) + "\n    upAxis = \"" +
           (up == UpAxis::Z ? "Z" : "Y") + "\"\n)\n\ndef Volume \"volume\"\n{\n" + extent_of(file) + fields + prims +
           "}\n";
}

std::string relative_asset(const std::string& file, const std::string& beside)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::absolute(fs::path(beside)).parent_path().lexically_normal();
    const std::string path = fs::absolute(file).lexically_normal().lexically_relative(folder).string();
    return path.rfind("../", 0) == 0 ? path : "./" + path;
}

}  // namespace vdbcloud
