#include "vdbcloud/grid/select.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/schema.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>

namespace vdbcloud {

namespace {

std::vector<GridBasePtr> all_called(const GridFile& file, const std::string& name)
{
    std::vector<GridBasePtr> found;
    for (const auto& grid : file.grids)
        if (grid && grid->getName() == name) found.push_back(grid);
    return found;
}

/// Splits "NAME[k]" into NAME and k; false if `text` does not end in "[k]".
bool split_index(const std::string& text, std::string& name, size_t& index)
{
    const size_t open = text.rfind('[');
    if (open == std::string::npos || text.back() != ']') return false;
    const char *begin = text.data() + open + 1, *end = text.data() + text.size() - 1;
    const auto [stop, code] = std::from_chars(begin, end, index);
    if (begin == end || stop != end || code != std::errc()) return false;
    name = text.substr(0, open);
    return true;
}

/// A vec3s grid from three float grids with equal transforms, active where at least one of the three is active.
Vec3SGridPtr merged(const std::array<const FloatGrid*, 3>& parts, const std::string& name)
{
    const auto result =
        Vec3SGrid::create(Vec3f(parts[0]->background(), parts[1]->background(), parts[2]->background()));
    result->setTransform(parts[0]->transform().copy());
    result->setName(name);
    for (const auto* part : parts) {
        if (part->transform() != parts[0]->transform())
            throw InputError("grid '" + printable(part->getName()) + "': its transform differs from that of '" +
                             printable(parts[0]->getName()) + "', with which it makes one vector");
        result->tree().topologyUnion(part->tree());
    }
    const auto x = parts[0]->getConstAccessor(), y = parts[1]->getConstAccessor(), z = parts[2]->getConstAccessor();
    result->tree().voxelizeActiveTiles();
    for (auto it = result->beginValueOn(); it; ++it) {
        const auto ijk = it.getCoord();
        it.setValue(Vec3f(x.getValue(ijk), y.getValue(ijk), z.getValue(ijk)));
    }
    return result;
}

/// Merges a vector that other programs write as three scalar grids: NAME.x NAME.y NAME.z, NAME_x ..., NAMEX ...
Vec3SGridPtr from_components(const GridFile& file, const std::string& role, const std::vector<std::string>& suffixes)
{
    for (const std::string& name : schema::aliases(role))
        for (size_t first = 0; first < suffixes.size(); first += 3) {
            std::array<const FloatGrid*, 3> parts{};
            for (size_t axis = 0; axis < 3; ++axis)
                parts[axis] = dynamic_cast<const FloatGrid*>(find_grid(file, name + suffixes[first + axis]).get());
            if (parts[0] && parts[1] && parts[2]) return merged(parts, role);
        }
    return nullptr;
}

}  // namespace

std::vector<std::string> grid_labels(const GridFile& file)
{
    std::vector<std::string> labels;
    std::map<std::string, size_t> seen;
    for (const auto& grid : file.grids) {
        if (!grid) continue;
        const std::string name = grid->getName();
        const size_t k = seen[name]++;
        labels.push_back(all_called(file, name).size() > 1 ? name + "[" + std::to_string(k) + "]" : name);
    }
    return labels;
}

std::string grid_list(const GridFile& file)
{
    std::string list;
    for (const auto& label : grid_labels(file)) list += (list.empty() ? "'" : ", '") + printable(label) + "'";
    return list.empty() ? "no grids" : printable(list, 600);
}

GridBasePtr find_grid(const GridFile& file, const std::string& name)
{
    if (const auto found = all_called(file, name); !found.empty()) return found.front();
    std::string plain;
    size_t index = 0;
    if (!split_index(name, plain, index)) return nullptr;
    const auto found = all_called(file, plain);
    return index < found.size() ? found[index] : nullptr;
}

GridBasePtr chosen_grid(const GridFile& file, const std::string& name)
{
    const std::string path = printable(file.path, 4096);
    const auto grid = find_grid(file, name);
    if (!grid) throw InputError(path + ": no grid '" + printable(name) + "': it has " + grid_list(file));
    if (const auto same = all_called(file, name); same.size() > 1)
        throw InputError(path + ": " + std::to_string(same.size()) + " grids are called '" + printable(name) +
                         "': expected a choice among " + grid_list(file));
    return grid;
}

GridBasePtr aliased_grid(const GridFile& file, const std::string& role)
{
    const auto lower = [](std::string text) {
        for (char& c : text)
            if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
        return text;
    };
    for (const bool exact : {true, false})
        for (const std::string& alias : schema::aliases(role))
            for (const auto& grid : file.grids)
                if (grid && (exact ? grid->getName() == alias : lower(grid->getName()) == lower(alias)))
                    return chosen_grid(file, grid->getName());
    return nullptr;
}

GridBasePtr grid_of(const GridFile& file, const std::string& role, const std::string& asked)
{
    if (!asked.empty()) return chosen_grid(file, asked);
    if (const auto grid = aliased_grid(file, role)) return grid;
    if (role == schema::velocity)
        return from_components(file, role, {".x", ".y", ".z", "_x", "_y", "_z", "X", "Y", "Z"});
    if (role == schema::colour) return from_components(file, role, {".r", ".g", ".b", "_r", "_g", "_b"});
    return nullptr;
}

void put_grid(GridFile& file, const GridBasePtr& grid)
{
    const std::string name = grid->getName();
    for (auto& old : file.grids)
        if (old && old->getName() == name) {
            old = grid;
            return;
        }
    file.grids.push_back(grid);
}

void remove_grids(GridFile& file, const std::function<bool(const std::string&)>& test)
{
    const auto goes = [&](const GridBasePtr& grid) { return grid && test(grid->getName()); };
    file.grids.erase(std::remove_if(file.grids.begin(), file.grids.end(), goes), file.grids.end());
}

}  // namespace vdbcloud
