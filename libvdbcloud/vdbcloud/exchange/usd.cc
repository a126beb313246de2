#include "vdbcloud/exchange/usd.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"

#include <algorithm>
#include <cctype>
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
void expand(std::optional<std::pair<Vec3d, Vec3d>>& extent, const GridFile& file)
{
    openvdb::BBoxd all;
    if (extent) all = openvdb::BBoxd(extent->first, extent->second);
    for (const GridBasePtr& grid : file.grids) {
        openvdb::CoordBBox box;
        if (!is_field(*grid) || !grid->baseTree().evalActiveVoxelBoundingBox(box)) continue;
        const openvdb::BBoxd index(box.min().asVec3d() - Vec3d(0.5), box.max().asVec3d() + Vec3d(0.5));
        all.expand(grid->transform().indexToWorld(index));
    }
    if (!all.empty()) extent = {all.min(), all.max()};
}

}  // namespace

void UsdVolume::add(const GridFile& file, const std::string& asset, std::optional<int> frame)
{
    if (asset.find('@') != std::string::npos)
        throw InputError(printable(asset) + ": expected a name without @, which ends a path in USD");
    if (assets_.empty()) {
        std::set<std::string> taken;
        std::map<std::string, int> index;
        for (const GridBasePtr& grid : file.grids) {
            const std::string& name = grid->getName();
            const int number = index[name]++;
            if (is_field(*grid))
                fields_.push_back({prim_name(name, taken), name, is_vector(*grid) ? "float3" : "float", class_of(*grid),
                                   hint_of(*grid), number});
        }
        if (fields_.empty()) throw InputError(printable(file.path) + ": no grid of float or vec3s");
        header_ = "    metersPerUnit = " + shortest(get_number(*file.metadata, schema::meters_per_unit, 1)) +
                  "\n    upAxis = \"" + (read_up_axis(*file.metadata) == UpAxis::Z ? "Z" : "Y") + "\"\n";
    }
    for (const Field& field : fields_)
        if (!find_grid(file, field.name + "[" + std::to_string(field.index) + "]"))
            throw InputError(printable(file.path) + ": no grid '" + printable(field.name) +
                             "', which the first file of the sequence has; choose grids with --grid");
    expand(extent_, file);
    assets_.emplace_back(frame, asset);
}

/// The line of filePath: one path, or one for each time code.
std::string UsdVolume::path_of_fields() const
{
    if (!assets_.front().first) return "asset filePath = @" + assets_.front().second + "@\n";
    std::string samples;
    for (const auto& [frame, asset] : assets_)
        samples += "            " + std::to_string(*frame) + ": @" + asset + "@,\n";
    return "asset filePath.timeSamples = {\n" + samples + "        }\n";
}

std::string UsdVolume::text() const
{
    std::string fields, prims, times;
    const std::string path = path_of_fields();
    for (const Field& field : fields_) {
        fields += "    rel field:" + field.prim + " = </volume/" + field.prim + ">\n";
        prims += "\n    def OpenVDBAsset \"" + field.prim + "\"\n    {\n        " + path +
                 "        token fieldName = " + quoted(field.name) +
                 "\n        int fieldIndex = " + std::to_string(field.index) + "\n        token fieldDataType = \"" +
                 field.type + "\"\n        token fieldClass = \"" + field.grid_class +
                 "\"\n        token vectorDataRoleHint = \"" + field.hint + "\"\n    }\n";
    }
    if (assets_.front().first) {
        const auto [first, last] = std::minmax_element(assets_.begin(), assets_.end());
        times = "    startTimeCode = " + std::to_string(*first->first) +
                "\n    endTimeCode = " + std::to_string(*last->first) + "\n";
    }
    const std::string extent =
        extent_ ? "    float3[] extent = [" + point(extent_->first) + ", " + point(extent_->second) + "]\n" : "";
    return "#usda 1.0\n(\n    defaultPrim = \"volume\"\n" + times + header_ + ")\n\ndef Volume \"volume\"\n{\n" +
           extent + fields + prims + "}\n";
}

std::string relative_asset(const std::string& file, const std::string& beside)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::absolute(fs::path(beside)).parent_path().lexically_normal();
    const std::string path = fs::absolute(file).lexically_normal().lexically_relative(folder).string();
    return path.rfind("../", 0) == 0 ? path : "./" + path;
}

}  // namespace vdbcloud
