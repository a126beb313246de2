// What the stages hand to each other: which grid is the density, what --keep none keeps, equal bytes, and that every
// grid, key of metadata and key of the report is in docs/format.md.
#include "stages.h"

#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

namespace vdbcloud::test {
namespace {

TEST_F(Stages, DensityOfUnknownNameIsFoundBesideMoments)
{
    const std::string lit = stage("p1solve", unknown(), "lit.vdb",
                                  with(medium, {"--iterations", "2", "--degree", "3", "--directions", "16"}));
    const Words grids = names(lit);
    EXPECT_EQ(std::count_if(grids.begin(), grids.end(),
                            [](const std::string& name) { return schema::has_role(name, schema::Role::Moment); }),
              5 + 7);
    const auto found = picture(lit, {}), asked = picture(lit, {"--density", "blob"});
    EXPECT_EQ(found, asked);
    EXPECT_GT(*std::max_element(found.begin(), found.end()), 0.01f);
}

TEST_F(Stages, DensityOfUnknownNameIsFoundBesideASeries)
{
    const std::string series = stage("p1solve", unknown(), "series.vdb", with(medium, {"--series", "3", "--galerkin"}));
    const auto found = picture(series, {"--albedo", "0.8"}),
               asked = picture(series, {"--albedo", "0.8", "--density", "blob"});
    EXPECT_EQ(found, asked);
    EXPECT_GT(*std::max_element(found.begin(), found.end()), 0.01f);
}

TEST_F(Stages, KeepNoneKeepsTheSeriesThatRenderReads)
{
    const std::string ball = write_ball("a.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const std::string series = stage("p1solve", ball, "series.vdb", with(medium, {"--series", "3", "--galerkin"}));
    const std::string kept = stage("illuminate", series, "kept.vdb", {"--keep", "none"});
    EXPECT_EQ(names(kept).size(), names(series).size());
    EXPECT_EQ(picture(kept, {"--albedo", "0.8"}), picture(series, {"--albedo", "0.8"}));
}

TEST_F(Stages, KeepNoneKeepsWhatP1solveUsed)
{
    const auto tint = Vec3SGrid::create(Vec3f(1.0f)), glow = Vec3SGrid::create(Vec3f(0.0f));
    tint->setName("colour");
    glow->setName("emission");
    glow->fill(openvdb::CoordBBox::createCube({0, 0, 0}, 2), Vec3f(0.1f));
    tint->fill(openvdb::CoordBBox::createCube({0, 0, 0}, 2), Vec3f(0.5f));
    const std::string input = write_ball("a.vdb", "blob", openvdb::GRID_FOG_VOLUME,
                                         {tint, glow, ball("heat", 3), ball("flame", 3), ball("dye", 3)});
    const Words kept = names(stage("p1solve", input, "lit.vdb", with(medium, {"--keep", "none"})));
    const std::set<std::string> set(kept.begin(), kept.end());
    for (const char* name : {"blob", "colour", "emission", "heat", "flame", "phi", "transmittance_sun"})
        EXPECT_TRUE(set.count(name)) << name;
    EXPECT_FALSE(set.count("dye"));
}

TEST_F(Stages, EqualRunsWriteEqualBytes)
{
    const std::string input = write_ball("a.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const auto bytes = [&](const std::string& threads) {
        std::string all;
        const auto add = [&](const std::string& path) {
            all += test::read_text(path);
            return path;
        };
        add(stage("fractalgen", "", "cloud.vdb", {"--size", "24", "--threads", threads}));
        const std::string light =
            add(stage("illuminate", input, "light.vdb", {"--sun", "1,2,3", "--threads", threads}));
        add(stage("p1solve", light, "lit.vdb",
                  {"--albedo", "0.9", "--g", "0.5", "--iterations", "2", "--degree", "2", "--directions", "16",
                   "--threads", threads}));
        add(stage("p1solve", light, "half.vdb", {"--albedo", "0.9", "--half", "--threads", threads}));
        return all;
    };
    const std::string one = bytes("1");
    EXPECT_GT(one.size(), 100000u);
    EXPECT_TRUE(one == bytes("1")) << "two runs";
    EXPECT_TRUE(one == bytes("2")) << "two threads";
    const std::string tool = "illuminate '" + input + "' --sun 1,2,3 -o - > ";
    test::RunOptions there;
    there.folder = scratch.path();
    EXPECT_EQ(shell(tool + "p1 && " + tool + "p2", there).status, 0);
    EXPECT_TRUE(test::read_text(scratch / "p1") == test::read_text(scratch / "p2")) << "through a pipe";
    EXPECT_GT(test::read_text(scratch / "p1").size(), 10000u);
}

/// Keys of a report as docs/format.md writes them, by path; inside `parameters` none.
void collect(const nlohmann::json& value, const std::string& path, std::set<std::string>& keys)
{
    if (value.is_object() && path != "parameters" && !value.empty()) {
        for (const auto& [key, inner] : value.items()) collect(inner, path.empty() ? key : path + "." + key, keys);
    } else if (value.is_array() && !value.empty() && value.front().is_object()) {
        for (const auto& entry : value) collect(entry, path + "[]", keys);
    } else if (!value.empty() || !(value.is_object() || value.is_array())) {
        keys.insert(path);
    }
}

/// The first cells of the rows below "## The report", as patterns.
std::vector<std::regex> documented_keys()
{
    std::vector<std::regex> all;
    std::istringstream page(test::read_text(std::string(VDBCLOUD_SOURCE) + "/docs/format.md"));
    bool inside = false;
    for (std::string line; std::getline(page, line);) {
        if (line.rfind("## ", 0) == 0) inside = line == "## The report";
        if (!inside || line.rfind("| `", 0) != 0) continue;
        const std::string key = line.substr(3, line.find('`', 3) - 3);
        std::string pattern;
        for (const char c : key)
            pattern += c == '.' || c == '[' || c == ']' ? std::string("\\") + c : std::string(1, c);
        for (const auto& [word, stands] : std::vector<std::pair<std::string, std::string>>{
                 {"LIGHT", "[A-Za-z0-9_]+"}, {"NAME", "[^.]+"}, {"\\.C\\.", "\\.[rgb]\\."}})
            for (size_t at; (at = pattern.find(word)) != std::string::npos;) pattern.replace(at, word.size(), stands);
        if (key == "outputs[].grids[]")
            pattern += "\\.(name|type|class|active_voxels|active_tiles|memory_bytes|voxel_size|"
                       "index_min|index_max|not_finite|min|max|mean)";
        all.emplace_back(pattern);
    }
    return all;
}

TEST_F(Stages, EverythingTheProgramsWriteIsInTheFormatsPage)
{
    int reports = 0;
    Words json;
    const auto report = [&] {
        json.push_back(scratch / ("report" + std::to_string(reports++)));
        return Words{"--json", json.back()};
    };
    const std::string cloud = stage("fractalgen", "", "cloud.vdb", with({"--size", "24"}, report()));
    for (const char* frame : {"frame.1.vdb", "frame.2.vdb"}) stage("fractalgen", "", frame, {"--size", "8"});
    stage("illuminate", scratch / "frame.%d.vdb", "lit.%d.vdb", with({"--frames", "1-2"}, report()));
    const std::string light =
        stage("illuminate", cloud, "light.vdb",
              with({"--sun", "1,2,3", "--lamp", "0,2,0", "--error-samples", "20", "--rung", "4"}, report()));
    const std::string lit =
        stage("p1solve", light, "lit.vdb",
              with({"--albedo", "0.9", "--g", "0.5", "--iterations", "2", "--degree", "2", "--directions", "16",
                    "--reentry-rays", "1000", "--sky", "0.1", "--heating", "--flux-map", scratch / "map.exr"},
                   report()));
    const std::string series = stage("p1solve", write_ball("a.vdb", "density", openvdb::GRID_FOG_VOLUME), "series.vdb",
                                     with(medium, with({"--series", "3", "--galerkin", "--series-raw"}, report())));
    write_text(scratch / "boxes.txt", "0 0 0  8 8 8  1 0\n3 3 3  5 5 5  1 1\n");
    const std::string glowing =
        stage("vdbimport", scratch / "boxes.txt", "glowing.vdb", with({"--boxes", "--cell", "1,1,1"}, report()));
    stage("p1solve", glowing, "lit.glowing.vdb", with({"--albedo", "0.5", "--voxel-error"}, report()));
    const std::string above =
        stage("p1solve", glowing, "above.vdb",
              with({"--albedo", "0.5", "--sun", "0,1,0", "--periodic", "xz", "--ground-albedo", "0.3"}, report()));
    stage("p1solve", glowing, "alone.vdb",
          with({"--albedo", "0.5", "--sun", "0,1,0", "--iterations", "1", "--ground-albedo", "0.3"}, report()));
    stage("p1solve", cloud, "limited.vdb", with(with(medium, {"--limiter", "levermore-pomraning"}), report()));
    stage("p1solve", cloud, "plan.vdb", with({"--dry-run", "--iterations", "1", "--directions", "8"}, report()));
    stage("render", lit, "lit.exr", with({"--resolution", "8"}, report()));
    stage("render", lit, "lit.exr", with({"--resolution", "8", "--dry-run"}, report()));
    stage("render", light, "certified.exr",
          with({"--resolution", "8", "--certify", "90%", "--error-png", scratch / "errors.png"}, report()));
    const std::string air = stage("cloudsim", "", "air.vdb", with({"--cells", "16,12,20", "--minutes", "1"}, report()));
    run(with({program("vdbdiff"), cloud, light}, report()));
    run(with({program("vdbprobe"), lit, "--grid", "phi", "--at", "0,0,0"}, report()));
    write_text(scratch / "table.txt", "1 2\n");
    const std::string imported =
        stage("vdbimport", scratch / "table.txt", "imported.vdb", with({"--cell", "1,1,1"}, report()));
    write_text(scratch / "particles.csv", "x,y,z,radius\n1,2,3,4\n");
    stage("vdbimport", scratch / "particles.csv", "particles.vdb", report());
    run(with({program("vdbexport"), glowing, "-o", scratch / "glowing.nc"}, report()));
    stage("vdbimport", scratch / "glowing.nc", "field.vdb", with({"--unit", "extinction=1/m"}, report()));

    const auto documented = documented_keys();
    EXPECT_GT(documented.size(), 80u);
    std::set<std::string> keys;
    for (const std::string& path : json) {
        const auto parsed = nlohmann::json::parse(read_text(path), nullptr, false);
        ASSERT_TRUE(parsed.is_object()) << path;
        EXPECT_EQ(parsed["schema"], 1) << path;
        collect(parsed, "", keys);
    }
    EXPECT_GT(keys.size(), 120u);
    std::vector<bool> used(documented.size(), false);
    const std::string frame = "frames[].";
    bool frames_told = false;
    for (const std::string& key : keys) {
        // What a frame reports has the names of a single run.
        const bool in_frame = key.rfind(frame, 0) == 0 && key != frame + "number";
        const std::string name = in_frame ? key.substr(frame.size()) : key;
        bool known = false;
        for (size_t k = 0; k < documented.size(); ++k)
            if (std::regex_match(name, documented[k])) known = used[k] = true;
        frames_told = frames_told || in_frame;
        EXPECT_TRUE(known) << key << " is not in docs/format.md";
    }
    EXPECT_TRUE(frames_told);
    // Where the page has more: what only failures, a plan of cloudsim and lists with entries report, and frames[].NAME.
    EXPECT_GE(std::count(used.begin(), used.end(), true), long(documented.size()) - 7);

    for (const std::string& path : {cloud, light, lit, series, above, glowing, air, imported}) {
        const GridFile file = read_grid_file(path);
        EXPECT_EQ(get_number(*file.metadata, schema::format, 0), schema::format_version) << path;
        const auto check = [&](const MetaMap& map, const std::string& of) {
            const std::set<std::string> openvdbs{"name", "class", "is_local_space", "is_saved_as_half_float",
                                                 "vector_type"};
            for (auto meta = map.beginMeta(); meta != map.endMeta(); ++meta)
                EXPECT_TRUE(schema::meta_key(meta->first) || openvdbs.count(meta->first) ||
                            meta->first.rfind("file_", 0) == 0)
                    << meta->first << " of " << of;
        };
        check(*file.metadata, path);
        for (const GridBasePtr& grid : file.grids) {
            const schema::GridKind* kind = schema::kind_of(grid->getName());
            ASSERT_TRUE(kind) << path << ": " << grid->getName();
            EXPECT_NE(std::string(kind->type).find(grid->valueType()), std::string::npos) << grid->getName();
            EXPECT_EQ(GridBase::gridClassToString(grid->getGridClass()), kind->grid_class) << grid->getName();
            check(*grid, path + ": " + grid->getName());
        }
    }
}

}  // namespace
}  // namespace vdbcloud::test
