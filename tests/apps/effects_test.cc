// Each option has an effect where it should, and is refused where it can have none: all of --help, program by program.
#include "apps/effect_rows.h"
#include "support/netcdf_maker.h"
#include "support/picture_file.h"
#include "support/run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

Words split(const std::string& text)
{
    std::istringstream in(text);
    Words words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

bool is_input(const std::string& word) { return word.size() > 4 && word.substr(word.size() - 4) == ".vdb"; }
bool is_option(const std::string& word) { return word[0] == '-' && word.size() > 1 && !std::isdigit(word[1]); }

/// A command in options with their values and inputs.
struct Parsed {
    std::map<std::string, Words> options;  // name, then each value ("" for a flag) in order
    Words inputs;
};

Parsed parsed(const Words& words)
{
    Parsed all;
    for (size_t k = 0; k < words.size(); ++k) {
        if (!is_option(words[k])) {
            all.inputs.push_back(words[k]);
        } else {
            const bool value = k + 1 < words.size() && !is_option(words[k + 1]) &&
                               !(is_input(words[k + 1]) && words[k] != "-o" && words[k] != "--envelope-from" &&
                                 words[k] != "--detail-from" && words[k] != "--start-from" && words[k] != "--init" &&
                                 words[k] != "--resume");
            all.options[words[k]].push_back(value ? words[k + 1] : "");
            k += value;
        }
    }
    return all;
}

/// `more` over `base`: options of the same name and inputs are replaced.
Words joined(const std::string& base, const std::string& more)
{
    Parsed all = parsed(split(base));
    Words late;
    const Words extra = split(more);
    const Parsed over = parsed(extra);
    for (const auto& [name, values] : over.options) all.options[name] = values;
    if (!over.inputs.empty()) all.inputs = over.inputs;
    Words words = all.inputs;
    for (const auto& [name, values] : all.options)
        for (const std::string& value : values) {
            words.push_back(name);
            if (!value.empty()) words.push_back(value);
        }
    return words;
}

std::string text(const Words& words)
{
    std::string all;
    for (const std::string& word : words) all += word + " ";
    return all;
}

/// All directions at 0.5 and 0.25 where red is, but for a sun of 1000 in one of 64 x 32 pixels. Radiance's .hdr, flat.
std::string sky_with_a_sun()
{
    std::string all = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n";
    for (int n = 0; n < 64 * 32; ++n) {
        const bool sun = n == 10 * 64 + 20, left = n % 64 < 32;
        all += {char(left ? 64 : 128), char(128), char(128), char(sun ? 139 : 128)};
    }
    return all;
}

class OptionEffects : public testing::TestWithParam<ToolEffects> {
protected:
    /// in.vdb: a cloud. rock.vdb: with a mountain. lattice.vdb, exact.vdb, solved.vdb: their light. seed, moved,
    /// albedo: other clouds.
    static void SetUpTestSuite()
    {
        inputs_ = new Scratch();
        write_text(*inputs_ / "table.txt", "0 1 2\n3 4 2\n");
        write_text(*inputs_ / "thickness.txt", "0.1 120 40\n60 50 130\n");
        write_text(*inputs_ / "boxes.txt", "0 0 0 90 90 90 0.1\n");
        write_text(*inputs_ / "points.txt", "0 0.3 0\n");
        write_text(*inputs_ / "map.pgm", std::string("P5\n2 2\n255\n") + std::string({0, 127, '\xff', 60}));
        write_text(*inputs_ / "sky.hdr", sky_with_a_sun());
        std::string numbers;
        for (int k = 0; k < 24; ++k) numbers += std::string({char(k), 0, 0, 63});
        write_text(*inputs_ / "numbers.raw", numbers);
        write_text(*inputs_ / "points.csv", "x,y,z\n1,2,3\n90,70,200\n");
        write_model(*inputs_ / "model.nc");
        const RunResult r =
            in_folder("fractalgen -q --size 16 -o in.vdb && fractalgen -q in.vdb --mountain --size 16 -o rock.vdb && "
                      "illuminate -q in.vdb --extinction 20 --sun 0.3,1,0.2 -o lattice.vdb && "
                      "illuminate -q in.vdb --extinction 20 --sun 0.3,1,0.2 --fidelity exact -o exact.vdb && "
                      "p1solve -q lattice.vdb -o solved.vdb && "
                      "fractalgen -q --size 16 --seed 2 -o seed.vdb && fractalgen -q --size 16 --bounds "
                      "0,0,0,4,2.5,4 -o moved.vdb && "
                      "fractalgen -q --size 16 --albedo 0.5 -o albedo.vdb && "
                      "cloudsim -q --cells 8 --minutes 0.5 --unpruned --seed 3 --noise 2 -o start.vdb");
        ASSERT_EQ(r.status, 0) << r.err;
        write_fire();
    }
    /// fire.vdb: the cloud with a temperature and a flame.
    static void write_fire()
    {
        GridFile file = read_grid_file(*inputs_ / "in.vdb");
        const auto density = openvdb::gridPtrCast<FloatGrid>(file.grids.at(0));
        for (const auto& [name, top] : {std::pair{"temperature", 1800.0f}, {"flame", 1.0f}}) {
            const auto grid = density->deepCopy();
            for (auto v = grid->beginValueOn(); v; ++v) v.setValue(top * *v);
            grid->setName(name);
            file.grids.push_back(grid);
        }
        write_grid_file(*inputs_ / "fire.vdb", file);
    }
    static void TearDownTestSuite()
    {
        delete inputs_;
        inputs_ = nullptr;
    }

    static RunResult in_folder(const std::string& line)
    {
        RunOptions there;
        there.folder = inputs_->path();
        return shell(line, there);
    }

    /// One run in the folder of the inputs; its files go to `folder`.
    struct Outcome {
        RunResult run;
        std::string folder, channels;
    };
    Outcome run_in(const std::string& folder, const Words& words)
    {
        namespace fs = std::filesystem;
        fs::remove_all(*inputs_ / folder);
        fs::create_directory(*inputs_ / folder);
        for (const auto& entry : fs::directory_iterator(inputs_->path()))
            if (entry.is_regular_file())
                fs::create_symlink(entry.path(), *inputs_ / (folder + "/") + entry.path().filename().string());
        std::string line = "cd " + folder + " && " + GetParam().tool;
        for (const std::string& word : words) line += " '" + word + "'";
        if (GetParam().tool != "vdbdiff") line += " --json report.json";
        Outcome outcome{in_folder(line), *inputs_ / folder, ""};
        const auto report = nlohmann::json::parse(read_text(outcome.folder + "/report.json"), nullptr, false);
        if (report.is_object())
            outcome.channels = report.value("accuracy", nlohmann::json()).dump() +
                               report.value("channels", nlohmann::json()).dump() +
                               report.value("points", nlohmann::json()).dump();
        return outcome;
    }

    static std::set<std::string> files(const std::string& folder)
    {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder)) names.insert(entry.path().filename());
        return names;
    }

    bool differ(const Outcome& a, const Outcome& b, const EffectRow& row)
    {
        const auto both = [&](const std::string& tool, const std::string& name) {
            return in_folder(tool + " '" + a.folder + "/" + name + "' '" + b.folder + "/" + name + "'").status;
        };
        switch (row.seen) {
        case Seen::Status: return a.run.status != b.run.status;
        case Seen::Report: return a.channels != b.channels;
        case Seen::Files: return files(a.folder) != files(b.folder);
        case Seen::Png: return both("idiff -q -fail 0 -warn 0", "out.png") != 0;
        case Seen::Metadata: return both("vdbdiff -q --metadata", "out.vdb") == 3;
        case Seen::Elsewhere: return true;
        case Seen::Values: break;
        }
        return GetParam().tool == "render" ? !picture(a.folder + "/out.exr").same_values(picture(b.folder + "/out.exr"))
                                           : both("vdbdiff -q", "out.vdb") == 3;
    }

    static Scratch* inputs_;
};

Scratch* OptionEffects::inputs_ = nullptr;

INSTANTIATE_TEST_SUITE_P(Tools, OptionEffects, testing::ValuesIn(tool_effects()),
                         [](const auto& p) { return p.param.tool; });

TEST_P(OptionEffects, TheTableHasARowForEachOptionInHelp)
{
    std::set<std::string> help, table;
    std::istringstream lines(run({program(GetParam().tool), "--help-all"}).out);
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("  -", 0) != 0) continue;
        std::istringstream words(line.substr(line.find("--")));
        std::string name;
        words >> name;
        if (name.back() == ',') name.pop_back();
        help.insert(name);
    }
    for (const EffectRow& row : GetParam().rows) table.insert(split(row.option).front());
    for (const auto& [name, test] : shared_options())
        if (help.count(name)) table.insert(name);
    EXPECT_EQ(help, table);
}

TEST_P(OptionEffects, EachOptionChangesTheResult)
{
    std::map<std::string, Outcome> done;  // many rows begin from one command
    for (const EffectRow& row : GetParam().rows) {
        if (row.seen == Seen::Elsewhere) continue;
        const Words plain = joined(GetParam().base, row.with), with = joined(text(plain), row.option);
        Outcome& a = done[text(plain)];
        if (a.folder.empty()) a = run_in("without" + std::to_string(done.size()), plain);
        const Outcome b = run_in("with", with);
        if (row.seen != Seen::Status) {
            EXPECT_EQ(a.run.status, 0) << text(plain) << "\n" << a.run.err;
            EXPECT_EQ(b.run.status, 0) << text(with) << "\n" << b.run.err;
        }
        EXPECT_TRUE(differ(a, b, row)) << row.option << " changes nothing in: " << text(with) << "\n" << b.run.err;
    }
}

TEST_P(OptionEffects, WithoutEffectAnOptionIsRefusedByName)
{
    for (const EffectRow& row : GetParam().rows) {
        if (row.always) continue;
        const Words words = joined(text(joined(GetParam().base, row.without)), row.option);
        const RunResult r = run_in("refused", words).run;
        EXPECT_EQ(r.status, 2) << text(words) << "\n" << r.err;
        EXPECT_NE(r.err.find(split(row.option).front()), std::string::npos) << text(words) << "\n" << r.err;
    }
}

}  // namespace
}  // namespace vdbcloud::test
