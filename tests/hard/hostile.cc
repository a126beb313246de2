#include "hard/hostile.h"

#include "hard/mutants.h"

#include "support/run.h"
#include "support/size.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

const Words grids{"cloud.vdb", "solved.vdb", "moments.vdb", "air.vdb", "solid.vdb", "colours.vdb"};

/// Whole numbers of one width, the lowest byte first.
std::string little(size_t width, std::initializer_list<uint32_t> numbers)
{
    std::string bytes;
    for (const uint32_t number : numbers)
        for (size_t k = 0; k < width; ++k) bytes += char(number >> (8 * k));
    return bytes;
}

/// Pictures of 8 x 4 pixels in formats that the programs do not write.
std::map<std::string, std::string> made_pictures()
{
    const std::string grey(8 * 4, 'a'), colours(8 * 4 * 3, 'a');
    std::string tags;  // of a .tif: number, type 3 or 4 (two or four bytes), count, value
    for (const auto& [tag, value] : std::initializer_list<std::pair<uint32_t, uint32_t>>{
             {256, 8}, {257, 4}, {258, 8}, {259, 1}, {262, 1}, {273, 8}, {277, 1}, {278, 4}, {279, 32}})
        tags += little(2, {tag, tag == 273 || tag == 279 ? 4u : 3u}) + little(4, {1, value});
    return {
        {"map.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + std::string(8 * 4 * 4, '\x80')},
        {"map.ppm", "P6\n8 4\n255\n" + colours},
        {"map.bmp",
         "BM" + little(4, {150, 0, 54, 40, 8, 4}) + little(2, {1, 24}) + little(4, {0, 96, 0, 0, 0, 0}) + colours},
        {"map.tga", little(1, {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0}) + little(2, {8, 4}) + little(1, {24, 0}) + colours},
        {"map.tif", "II*" + little(1, {0}) + little(4, {8 + 32}) + grey + little(2, {9}) + tags + little(4, {0})}};
}

std::string extension_of(const std::string& name) { return name.substr(name.rfind('.') + 1); }

Words names_in(const std::string& folder)
{
    Words names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace

const Words& Hostile::tools()
{
    // New programs at the end: the seeds of a program depend on its place.
    static const Words all{"fractalgen", "cloudsim", "vdbimport", "illuminate", "p1solve",
                           "render",     "exrmerge", "vdbdiff",   "vdbprobe",   "vdbexport"};
    return all;
}

std::vector<Hostile::Slot> Hostile::slots(const std::string& tool)
{
    // What a program takes beside a configuration.
    static const std::map<std::string, std::string> complete{{"fractalgen", "-o out.vdb"},
                                                             {"cloudsim", "-o out.vdb"},
                                                             {"vdbimport", "table.txt --cell 1,1,1 -o out.vdb"},
                                                             {"vdbexport", "cloud.vdb -o out.nc"},
                                                             {"illuminate", "cloud.vdb --sun 0,1,0 -o out.vdb"},
                                                             {"p1solve", "cloud.vdb -o out.vdb"},
                                                             {"render", "cloud.vdb -o out.exr"},
                                                             {"exrmerge", "part.exr part2.exr -o out.exr"},
                                                             {"vdbdiff", "cloud.vdb cloud.vdb"},
                                                             {"vdbprobe", "cloud.vdb --grid density --at 1,1,1"}};
    const Slot config{"text", {tool + ".toml"}, complete.at(tool) + " --config @ --dry-run", false};
    // A scene file, which every program reads that has an option of the picture.
    const Slot scene{"text", {"scene.toml"}, complete.at(tool) + " --scene @ --dry-run", false};
    const std::string air = "--cells 4 --minutes 0.05 --every 2s -o out.vdb ", flux = "--heat-flux 0.1 --floor-map @";
    if (tool == "fractalgen")
        return {{"grids", grids, "--size 4 --envelope-from @ -o out.vdb"},
                {"grids", grids, "@ --size 4 -o out.vdb"},
                config,
                scene};
    if (tool == "cloudsim")
        return {{"grids", {"air.vdb", "cloud.vdb", "solved.vdb"}, air + "--init @"},
                {"grids", grids, air + flux},
                {"picture",
                 {"map.png", "map.exr", "map.hdr", "map.ppm", "map.bmp", "map.tga", "map.tif"},
                 air + flux,
                 false},
                {"text", {"sounding.txt"}, air + "--sounding @", false},
                {"checkpoint",
                 {"state.bin"},
                 "--cells 4 --minutes 0.05 --every 1s --unpruned -o out.vdb --resume @",
                 false},
                {"text",
                 {"frames.log"},
                 "--cells 4 --minutes 0.05 --every 1s --unpruned -o out.vdb --resume state.bin --log @",
                 false},
                config};
    if (tool == "vdbimport")
        return {{"text", {"table.txt"}, "@ --cell 1,1,1 -o out.vdb"},
                {"text", {"thickness.txt"}, "table.txt --thickness @ --cell 1,1,1 -o out.vdb"},
                {"text", {"boxes.txt"}, "@ --boxes --cell 1,1,1 -o out.vdb"},
                {"text", {"particles.csv"}, "@ --cell 1,1,1 -o out.vdb", false},
                {"text", {"small.prp"}, "@ -o out.vdb", false},
                config,
                scene};
    if (tool == "vdbexport") return {{"grids", grids, "@ -o out.nc"}, {"grids", grids, "@ -o out.usda", false}, config};
    if (tool == "illuminate")
        return {{"grids", grids, "@ --sun 0.3,1,0.2 -o out.vdb"},
                {"grids", grids, "@ cloud.vdb -o out.vdb --lamp 9,1,1"},
                config,
                scene};
    if (tool == "p1solve")
        return {{"grids", grids, "@ --reentry-rays 50 -o out.vdb"},
                {"grids", grids, "@ --sun 0.3,1,0.2 --reentry-rays 50 --series 2 -o out.vdb"},
                {"grids", grids, "cloud.vdb @ --sun 0,1,0 --iterations 1 --directions 8 -o out.vdb"},
                config,
                scene};
    if (tool == "render")
        return {{"grids", grids, "@ --resolution 3 -o out.exr"},
                {"grids", grids, "@ --resolution 2 --integrator path --spp 1 -o out.exr"},
                {"grids", grids, "cloud.vdb @ --resolution 3 --sun 0,1,0 -o out.exr"},
                {"grids", {"solved.vdb"}, "@ --resolution 2 --albedo 0.9995 --direction 0,-1,0 -o out.exr"},
                config,
                scene};
    if (tool == "exrmerge") return {{"picture", {"part.exr"}, "@ part2.exr -o out.exr", false}, config};
    if (tool == "vdbdiff")
        return {{"grids", {"solved.vdb", "moments.vdb"}, "@ solved.vdb"},
                {"grids", {"solved.vdb"}, "solved.vdb @"},
                config};
    return {{"grids", grids, "@ --grid density --at 1,1,1"},
            {"text", {"points.txt"}, "cloud.vdb --grid density --points @"},
            config};
}

Words Hostile::refused_when_healthy()
{
    Words refused;
    for (const std::string& tool : tools())
        for (const Slot& slot : slots(tool)) {
            // Grids of other programs may be refused.
            const bool any = slot.kind != std::string("grids");
            for (size_t k = 0; k < (any ? slot.healthy.size() : 1); ++k) {
                Words words = split(slot.line);
                std::replace(words.begin(), words.end(), std::string("@"), slot.healthy[k]);
                if (programs_.run(tool, words, folder_).status != 0)
                    refused.push_back(tool + " " + slot.line + ": " + read_text(folder_ + "/stderr"));
            }
        }
    return refused;
}

void Hostile::make(const std::string& tool, const std::string& line)
{
    if (programs_.run(tool, split(line), folder_).status != 0)
        throw std::runtime_error(tool + " " + line + ": " + read_text(folder_ + "/stderr"));
}

Hostile::Hostile(Programs& programs, const std::string& folder) : programs_(programs), folder_(folder)
{
    make("fractalgen", "-q --size 6 --seed 3 --compression zip -o cloud.vdb");
    const World cube;
    write_own(folder_ + "/colours.vdb",
              make_body(programs_, "noise n=5,5,5 seed=2 emission=0.1 cd=3", cube.axes, cube.origin, {}, folder_));
    make("fractalgen", "-q --mountain --size 13 -o solid.vdb");
    make("p1solve", "-q cloud.vdb --sun 0.3,1,0.2 --g 0.5 --reentry-rays 50 --series 3 -o solved.vdb");
    make("p1solve", "-q cloud.vdb --sun 0.3,1,0.2 --sky-zenith 0.1,0.2,0.3 --g 0.5 --albedo 0.9 --degree 3 "
                    "--iterations 2 --directions 8 --ground-albedo 0.3 --heating --compression none -o moments.vdb");
    make("cloudsim",
         "-q --cells 4 --minutes 0.05 --every 1s --unpruned --checkpoint state.bin --log frames.log -o air.vdb");
    make("render", "-q solved.vdb --resolution 4 --integrator path --spp 1 -o part.exr");
    make("render", "-q solved.vdb --resolution 4 --integrator path --spp 1 --spp-offset 1 -o part2.exr");
    make("render", "-q solved.vdb --resolution 4 -o map.exr --png map.png");
    for (const std::string& tool : tools()) {
        make(tool, "--print-config");
        write_text(folder_ + "/" + tool + ".toml", read_text(folder_ + "/stdout"));
    }
    for (const auto& [name, bytes] : made_pictures()) write_text(folder_ + "/" + name, bytes);
    write_text(folder_ + "/scene.toml", "[medium]\nextinction = 2\ng = 0.5\n[[lights]]\nsun = [0, 1, 0]\ndiameter = 2\n"
                                        "[sky]\nzenith = [0.1, 0.2, 0.3]\n[camera]\nfov = 30\n"
                                        "[accuracy]\niterations = 1\ndirections = 8\n");
    write_text(folder_ + "/sounding.txt", "pressure 1000\n0 290 10 1 2\n500 291 9\n1500 299 3 0 0 # an inversion\n");
    write_text(folder_ + "/table.txt", "0 1 2 3\n1 2 0.5 1e-3\n# clear\n0 0 0 4\n");
    write_text(folder_ + "/thickness.txt", "0 1 2 3\n1 2 0.5 1\n1 1 1 4.5\n");
    write_text(folder_ + "/boxes.txt", "0 0 0 2 3 4 0.5 0\n1 1 1 2 2 2 1 0.25\n");
    write_text(folder_ + "/points.txt", "0 0 0\n1.5 2 -3\n# outside\n2 2 2\n");
    write_text(folder_ + "/particles.csv", "x,y,z,radius,mass\n0,1,2,0.5,1\n3,-1,0,2.5,2\n");
    write_text(folder_ + "/small.prp", "T\n2 1 2\n1 1 0 1\n1\n2 1.5 0.5\n1 1 1 280 4 0.9 1\n2 1 2 280 8 1 1\n");
    known_ = names_in(folder_);
}

const std::string& Hostile::healthy(const std::string& name)
{
    std::string& bytes = bytes_[name];
    if (bytes.empty()) bytes = read_text(folder_ + "/" + name);
    return bytes;
}

std::string Hostile::contents(const Slot& slot, const std::string& name, Dice& dice, std::string& what)
{
    const std::string kind = slot.kind;
    const std::string& bytes = healthy(name);
    const double how = uniform(dice.bits());
    if (how < 0.3 && kind != "checkpoint") return what = "damaged", damaged(bytes, dice);
    if (how < 0.4)
        return what = "spliced", spliced(bytes, healthy(slot.healthy[dice.below(slot.healthy.size())]), dice);
    if (kind == "text") return hostile_text(bytes, dice, what);
    if (kind == "picture") return hostile_picture(bytes, extension_of(name), dice, what);
    if (kind == "checkpoint") return hostile_checkpoint(bytes, dice, what);
    if (how < 0.5) return hostile_compression(bytes, dice, what);
    return hostile_grids(folder_ + "/" + name, dice, what);
}

Mutant Hostile::mutant(const std::string& tool, uint64_t seed)
{
    const auto number = std::find(tools().begin(), tools().end(), tool) - tools().begin();
    Dice dice(hash_bits(1984, seed, uint64_t(number)));
    const auto all = slots(tool);
    const Slot& slot = all[dice.below(all.size())];
    const std::string& from = slot.healthy[dice.below(slot.healthy.size())];
    Mutant mutant;
    mutant.name = "hostile." + extension_of(from);
    if (slot.kind == std::string("grids") && seed % 1000 == 7) {
        std::string& bytes = bytes_["many"];
        if (bytes.empty()) bytes = many_grids(sized(2000, 100000));
        mutant.bytes = bytes;
        mutant.what = "many grids";
    } else {
        do {
            mutant.what.clear();
            mutant.bytes = contents(slot, from, dice, mutant.what);
        } while (mutant.bytes == healthy(from));
    }
    mutant.what = from + ": " + mutant.what;
    const bool pipe = slot.pipe && dice.chance(0.3);
    if (pipe) mutant.input = mutant.name;
    mutant.arguments = split(slot.line);
    for (std::string& word : mutant.arguments)
        if (word == "@") word = pipe ? "-" : mutant.name;
    mutant.arguments.insert(mutant.arguments.end(), {"--threads", "1", "-q"});
    return mutant;
}

std::string complaint(const std::string& tool, int status, std::string said)
{
    if (status > 3) return "status " + std::to_string(status) + ": " + said.substr(0, 400);
    if (std::any_of(said.begin(), said.end(), [](char c) { return uint8_t(c) < 32 && c != '\n'; }))
        return "a control character in: " + said.substr(0, 400);
    if (said.size() > 65536) return "a message of " + std::to_string(said.size()) + " bytes";
    if (status == 0) return {};
    while (!said.empty() && said.back() == '\n') said.pop_back();
    const std::string last = said.substr(said.rfind('\n') + 1);
    return last.rfind(tool + ": ", 0) == 0 ? "" : "status " + std::to_string(status) + " without a sentence: " + last;
}

void Hostile::run(const std::string& tool, uint64_t seed)
{
    const Mutant mutant = this->mutant(tool, seed);
    write_text(folder_ + "/" + mutant.name, mutant.bytes);
    const Answer answer = programs_.run(tool, mutant.arguments, folder_, mutant.input);
    ++statuses_[answer.status];
    const std::string said = read_text(folder_ + "/stderr");
    std::string bad = complaint(tool, answer.status, said);
    for (const std::string& name : names_in(folder_)) {
        if (std::binary_search(known_.begin(), known_.end(), name)) continue;
        if (name != mutant.name && name.rfind("out.", 0) != 0) bad = "the file " + name + " stays";
        std::filesystem::remove_all(folder_ + "/" + name);
    }
    const std::string group = "hostile files: " + tool, where = "seed " + std::to_string(seed) + ": " + mutant.what;
    const double mebibytes = answer.bytes / 0x1p20;
    add_row(rows_, {group, "ends", bad.empty() ? 0.0 : 1.0, 0, 1, bad.empty() ? 0 : 1, bad.empty() ? "" : where, ""});
    add_row(rows_, {group, "seconds", answer.seconds, 20, 1, answer.seconds <= 20 ? 0 : 1, where, ""});
    add_row(rows_, {group, "MiB", mebibytes, 2048, 1, mebibytes <= 2048 ? 0 : 1, where, ""});
    if (said.find("the limit of processor time") != std::string::npos)
        add_row(rows_, {group, "seconds at which a limit of time ends", answer.seconds, 20, 1, 0, where, ""});
    if (bad.empty()) return;
    std::string line = tool;
    for (const std::string& word : mutant.arguments) line += " " + word;
    failures_.push_back({line + "\n", "ends", tool + " " + where + ": " + bad, 1, 0});
}

std::string Hostile::keep(const std::string& tool, uint64_t seed)
{
    const Mutant mutant = this->mutant(tool, seed);
    write_text(folder_ + "/" + mutant.name, mutant.bytes);
    std::string line = "# " + mutant.what + "\ncd " + folder_ + " && " + tool;
    for (const std::string& word : mutant.arguments) line += " " + word;
    return line + " < " + mutant.input;
}

}  // namespace vdbcloud::test
