// Reading and writing .vdb files under the shared options.
#include "plan.h"
#include "shared.h"

#include "version.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/statistics.h"
#include "vdbcloud/grid/tree_size.h"

#include <unistd.h>

#include <algorithm>

namespace vdbcloud::app {

namespace {

/// The names of a list between commas. A name of `known` may hold commas: where several names fit, the longest counts.
std::set<std::string> listed(const std::string& text, const std::set<std::string>& known)
{
    std::set<std::string> names;
    for (size_t from = 0; from <= text.size();) {
        size_t end = std::min(text.find(',', from), text.size());
        for (size_t longer = end; longer < text.size();) {
            longer = std::min(text.find(',', longer + 1), text.size());
            if (known.count(text.substr(from, longer - from))) end = longer;
        }
        if (end > from) names.insert(text.substr(from, end - from));
        from = end + 1;
    }
    return names;
}

nlohmann::json described(const GridFile& file)
{
    nlohmann::json all = nlohmann::json::array();
    for (const GridStatistics& g : file_statistics(file)) {
        nlohmann::json one = {{"name", g.label},
                              {"type", g.value_type},
                              {"class", g.grid_class},
                              {"active_voxels", g.active_voxels},
                              {"active_tiles", g.active_tiles},
                              {"memory_bytes", g.memory_bytes},
                              {"voxel_size", {g.voxel_size[0], g.voxel_size[1], g.voxel_size[2]}}};
        if (g.active_voxels > 0) {
            one["index_min"] = g.box_min;
            one["index_max"] = g.box_max;
        }
        if (g.has_values) {
            one["not_finite"] = g.not_finite;
            if (g.active_voxels > g.not_finite) one.update({{"min", g.min}, {"max", g.max}, {"mean", g.mean}});
        }
        all.push_back(one);
    }
    return all;
}

/// The values of all leaves of a file [bytes].
double bytes_of(const GridFile& file)
{
    double bytes = 0;
    for (const GridBasePtr& grid : file.grids) bytes += value_bytes(*grid);
    return bytes;
}

/// Grids that no --keep drops: results of earlier stages, and the density they belong to.
bool ours(const std::string& name)
{
    const schema::GridKind* kind = schema::kind_of(name);
    return kind && kind->kept;
}

}  // namespace

double value_bytes(const GridBase& grid)
{
    const std::string type = grid.valueType();
    const double each = type == "float" ? 4 : type == "vec3s" ? 12 : type == "vec3d" ? 24 : 8;
    return tree_size(grid).values(each);
}

GridFile App::read(const std::string& path)
{
    Shared& s = *shared_;
    if (path == "-" && ::isatty(STDIN_FILENO))
        throw UsageError("standard input is a terminal: pipe a .vdb into it, or name a file");
    const Phase reading(*this, "read");
    ReadOptions options;
    options.trust = s.trust_input;
    options.max_bytes = uint64_t(std::min(s.max_input * 0x1p30, 0x1p62));
    options.warn = warnings();
    ReadCost cost;
    GridFile file = read_grid_file(path, options, &cost);
    for (const std::string& sentence : passed_over(*file.metadata)) warnings()(printable(path, 4096) + ": " + sentence);
    for (const GridBasePtr& grid : file.grids) s.inherited_grids.insert(grid->getName());
    s.work.add("read_byte", bytes_of(file));
    if (!get_text(*file.metadata, schema::history, "").empty()) s.traced_inputs.insert(path);
    nlohmann::json input = {{"path", path},
                            {"bytes", cost.bytes},
                            {"digest", cost.digest},
                            {"guard_seconds", cost.guard_seconds},
                            {"read_seconds", cost.read_seconds}};
    if (!s.json.empty()) input["grids"] = described(file);
    report()["inputs"].push_back(input);
    return file;
}

void App::write(const std::string& path, GridFile& file)
{
    Shared& s = *shared_;
    if (s.dry_run) return;
    check_output(path);
    const Phase writing(*this, "write");
    set_text(*file.metadata, schema::creator, get_name() + " " + project_version());
    set_text(*file.metadata, schema::history, history(get_text(*file.metadata, schema::history, "")));

    GridFile kept = file;
    if (s.keep != "all") {
        std::set<std::string> known;
        for (const GridBasePtr& grid : file.grids) known.insert(grid->getName());
        const std::set<std::string> names = s.keep == "none" ? std::set<std::string>() : listed(s.keep, known);
        for (const std::string& name : names)
            if (!find_grid(file, name)) throw UsageError("--keep: there is no grid '" + one_line(name) + "' to keep");
        remove_grids(kept, [&](const std::string& name) {
            return s.inherited_grids.count(name) && !names.count(name) && !s.used.count(name) && !ours(name);
        });
    }
    WriteOptions options;
    options.compression = s.compression;
    options.half = s.half;
    options.no_clobber = s.no_clobber;
    options.warn = warnings();
    write_grid_file(path, kept, options);
    s.work.add("write_byte", bytes_of(kept));
    nlohmann::json output = {{"path", path}};
    if (!s.json.empty()) output["grids"] = described(kept);
    report()["outputs"].push_back(output);
}

}  // namespace vdbcloud::app
