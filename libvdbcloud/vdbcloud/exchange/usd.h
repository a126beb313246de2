#pragma once
// A description in USD of .vdb files, as a Volume whose fields are their grids.
#include "vdbcloud/grid/grid_file.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud {

/// A UsdVol Volume named `volume` with an OpenVDBAsset for each float or vec3s grid of one .vdb, or of the frames of a
/// sequence.
class UsdVolume {
public:
    /// `asset`: the path of the .vdb as the .usda names it. `frame`: its time code. The first file gives fields, up
    /// axis and metersPerUnit (1 where it has none). Throws InputError for a file without such grids, for one that
    /// lacks a grid of the first, and for a path with '@', which ends a path in USD.
    void add(const GridFile&, const std::string& asset, std::optional<int> frame = std::nullopt);

    /// The text of the .usda. extent is the box of the active voxels of all files.
    std::string text() const;

private:
    struct Field {
        std::string prim, name, type, grid_class, hint;
        int index;  // among grids of one name
    };
    std::string path_of_fields() const;

    std::vector<Field> fields_;
    std::vector<std::pair<std::optional<int>, std::string>> assets_;
    std::string header_;
    std::optional<std::pair<Vec3d, Vec3d>> extent_;
};

/// The path of `file` from the folder of `beside`: "./cloud.vdb".
std::string relative_asset(const std::string& file, const std::string& beside);

}  // namespace vdbcloud
