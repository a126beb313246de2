// The registry of names, and its agreement with docs/format.md in both directions.
#include "vdbcloud/grid/registry.h"

#include "support/run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace vdbcloud::schema {
namespace {

using Cells = std::vector<std::string>;

const std::string source = VDBCLOUD_SOURCE;

/// The rows of the tables below "## HEADING" whose first cell is in backticks. Cells are without surrounding blanks and
/// backticks.
std::vector<Cells> rows(const std::string& heading)
{
    std::vector<Cells> all;
    std::istringstream page(test::read_text(source + "/docs/format.md"));
    bool inside = false;
    for (std::string line; std::getline(page, line);) {
        if (line.rfind("## ", 0) == 0) inside = line == "## " + heading;
        if (!inside || line.rfind("| `", 0) != 0) continue;
        Cells cells;
        std::istringstream parts(line.substr(1));
        for (std::string cell; std::getline(parts, cell, '|');) {
            const size_t first = cell.find_first_not_of(" `"), last = cell.find_last_not_of(" `");
            cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
        }
        all.push_back(cells);
    }
    return all;
}

TEST(Registry, MapsEachNameToItsRole)
{
    const std::vector<std::pair<const char*, Role>> known = {{"density", Role::Density},
                                                             {"smoke", Role::Density},
                                                             {"Density", Role::Density},
                                                             {"medium_2", Role::Density},
                                                             {"Cd_3", Role::Colour},
                                                             {"heat", Role::Temperature},
                                                             {"fire", Role::Flame},
                                                             {"velocity", Role::Velocity},
                                                             {"Cd", Role::Colour},
                                                             {"albedo", Role::Colour},
                                                             {"emission", Role::Emission},
                                                             {"transmittance_sun", Role::Transmittance},
                                                             {"transmittance_2", Role::Transmittance},
                                                             {"phi", Role::Fluence},
                                                             {"flux", Role::Flux},
                                                             {"flux_r", Role::Flux},
                                                             {"flux_b", Role::Flux},
                                                             {"sh_20", Role::Moment},
                                                             {"sh_2m2_r", Role::Moment},
                                                             {"sh_3p3_g", Role::Moment},
                                                             {"sh_20_b", Role::Moment},
                                                             {"series_phi_0", Role::SeriesFluence},
                                                             {"series_I_3", Role::SeriesOrder},
                                                             {"heating", Role::Heating},
                                                             {"ground_radiance", Role::GroundRadiance},
                                                             {"solid", Role::Solid},
                                                             {"solid2", Role::Solid},
                                                             {"qt", Role::Water},
                                                             {"rain", Role::Rain},
                                                             {"dye", Role::Dye}};
    for (const auto& [name, role] : known) {
        ASSERT_TRUE(kind_of(name)) << name;
        EXPECT_EQ(kind_of(name)->role, role) << name;
        EXPECT_TRUE(has_role(name, role)) << name;
    }
    for (const char* name :
         {"blob",           "",        "densities", "flux_",   "flux_density", "flux_rg",      "sh_",
          "sh_shape",       "sh_2m_r", "sh_2",      "sh_20_a", "series_phi_",  "series_phi_x", "series_",
          "transmittance_", "phi_2",   "solid_2",   "medium_", "medium_x",     "Cd_"})
        EXPECT_FALSE(kind_of(name)) << name;
}

TEST(Registry, ContainsEveryBuiltName)
{
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(has_role(flux_name(c), Role::Flux));
    for (int l = 2; l <= 12; ++l)
        for (int m = -l; m <= l; ++m)
            for (int c = -1; c < 3; ++c)
                EXPECT_TRUE(has_role(moment_name(l, m, c), Role::Moment)) << moment_name(l, m, c);
    for (const size_t k : {0, 9, 10}) {
        EXPECT_TRUE(has_role(series_phi_name(k), Role::SeriesFluence));
        EXPECT_TRUE(has_role(series_raw_name(k), Role::SeriesOrder));
    }
}

TEST(Registry, KeepsWhatLaterStagesReadAndStoresResultsInFull)
{
    std::set<std::string> kept, half, result;
    for (const GridKind& kind : grid_kinds()) {
        if (kind.kept) kept.insert(kind.name);
        if (kind.half) half.insert(kind.name);
        if (kind.result) result.insert(kind.name);
    }
    EXPECT_EQ(kept, (std::set<std::string>{"density", "medium_", "transmittance_", "phi", "flux", "flux_", "sh_",
                                           "series_phi_", "series_I_", "ground_radiance", "environment", "solid"}));
    EXPECT_EQ(half, (std::set<std::string>{"density", "medium_", "Cd", "Cd_", "sh_"}));
    EXPECT_EQ(result, (std::set<std::string>{"transmittance_", "phi", "flux", "flux_", "series_phi_", "series_I_",
                                             "heating", "ground_radiance"}));
    EXPECT_EQ(aliases("Cd"), (std::vector<std::string>{"Cd", "color", "colour", "albedo"}));
    EXPECT_EQ(aliases("phi"), std::vector<std::string>{"phi"});
}

TEST(Format, ListsExactlyTheGridsOfTheRegistry)
{
    std::vector<Cells> expected;
    for (const GridKind& kind : grid_kinds())
        expected.push_back({std::string(kind.name) + kind.rest_text, kind.type, kind.unit, kind.grid_class,
                            kind.background, kind.stages});
    EXPECT_EQ(rows("Grids"), expected);
}

TEST(Format, ListsExactlyTheMetadataOfTheRegistry)
{
    std::vector<Cells> expected, found;
    for (const MetaKey& key : meta_keys()) expected.push_back({key.key, key.type, key.where});
    for (const Cells& row : rows("Metadata")) {
        ASSERT_EQ(row.size(), 6u) << row[0];
        EXPECT_FALSE(row[3].empty()) << row[0];
        EXPECT_FALSE(row[4].empty()) << row[0];
        found.push_back({row[0], row[1], row[2]});
    }
    EXPECT_EQ(found, expected);
}

TEST(Format, StatesTheFormatVersion)
{
    const std::string page = test::read_text(source + "/docs/format.md");
    EXPECT_NE(page.find("This is format version " + std::to_string(format_version) + "."), std::string::npos);
}

/// Searches the sources of the library and of all programs except render, whose keys are metadata of pictures.
TEST(Format, RegistryContainsEveryKeyInTheSources)
{
    const std::regex literal("\"((vdbcloud|cloudsim):[a-z_]+)\"");
    std::map<std::string, std::string> spelt;
    for (const char* folder : {"/libvdbcloud", "/apps"})
        for (const auto& entry : std::filesystem::recursive_directory_iterator(source + folder)) {
            const std::string path = entry.path().string(), extension = entry.path().extension().string();
            if ((extension != ".cc" && extension != ".h") || path.find("/render/") != std::string::npos) continue;
            const std::string text = test::read_text(path);
            for (std::sregex_iterator k(text.begin(), text.end(), literal), end; k != end; ++k) spelt[(*k)[1]] = path;
        }
    EXPECT_GT(spelt.size(), 20u) << "the sources are not where the test looks for them";
    spelt.erase("vdbcloud:series");  // the prefix of several keys
    for (const auto& [key, path] : spelt) EXPECT_TRUE(meta_key(key)) << key << " in " << path;
}

}  // namespace
}  // namespace vdbcloud::schema
