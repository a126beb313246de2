// Reading a damaged file gives grids or an error message, in bounded time and memory, and never ends the process.
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/statistics.h"

#include "support/damage.h"
#include "support/grids.h"
#include "support/redirect.h"
#include "support/run.h"
#include "support/size.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <map>

namespace vdbcloud {
namespace {

using namespace test;

/// Contents of the files to damage: each compression, both layouts (file, stream), and the files of data/odd.
std::map<std::string, std::string> seeds(const Scratch& folder)
{
    std::map<std::string, std::string> all;
    const auto fog = ball("density", 12, openvdb::Coord(24));
    fog->tree().addTile(1, openvdb::Coord(64, 0, 0), 0.5f, true);
    const auto velocity = Vec3SGrid::create(Vec3f(0));
    velocity->setName("vel");
    velocity->tree().setValue(openvdb::Coord(1, 2, 3), Vec3f(1, 2, 3));
    auto file = file_of({fog, velocity, ball("heat", 3, openvdb::Coord(4))});
    set_text(*file.metadata, "history", "fractalgen 0.1.0 seed=7");
    set_vector(*fog, "vdbcloud:albedo", Vec3d(1));
    WriteOptions options;
    for (const auto compression : {Compression::Blosc, Compression::Zip, Compression::None}) {
        options.compression = compression;
        options.half = compression == Compression::None;
        write_grid_file(folder / "seed.vdb", file, options);
        all["made" + std::to_string(int(compression))] = read_text(folder / "seed.vdb");
    }
    all["stream"] = output_of([&] { write_grid_file("-", file); });
    std::vector<std::string> folders = {VDBCLOUD_ODD};
    if (const char* real = std::getenv("VDBCLOUD_REAL")) folders.push_back(real);
    for (const auto& where : folders)
        for (const auto& entry : std::filesystem::directory_iterator(where))
            if (entry.path().extension() == ".vdb" && entry.file_size() < 400000)
                all[entry.path().filename()] = read_text(entry.path());
    return all;
}

/// Reads and writes the file as a program does. Returns a word for the outcome, for the test's report.
std::string outcome(const std::string& path)
{
    ReadOptions options;
    options.guard_cpu_seconds = 2;
    try {
        auto file = read_grid_file(path, options);
        file_statistics(file);
        const auto density = density_of(file);
        grid_digest(*density);
        write_grid_file("/dev/null", file);
        return "used";
    } catch (const IoError& e) {
        EXPECT_EQ(std::string(e.what()).find(path + ": "), 0u) << e.what();
        EXPECT_LT(std::strlen(e.what()), path.size() + 1200);
        return std::string(e.what()).find("breaks the reader") != std::string::npos ? "would have crashed"
               : std::string(e.what()).find("too large") != std::string::npos       ? "would have hung or filled memory"
                                                                                    : "refused";
    } catch (const InputError&) {
        return "read, no density";
    }
}

TEST(Fuzz, DamagedFilesAreReadOrRefusedWithoutCrash)
{
    const Scratch folder;
    const auto files = seeds(folder);
    const size_t each = std::max<size_t>(1, sized<size_t>(300, 5000) / files.size());
    std::map<std::string, int> outcomes;
    double slowest = 0;
    uint64_t number = 0;
    for (const auto& [name, bytes] : files) {
        ++number;
        for (size_t k = 0; k < each; ++k) {
            Dice dice(hash_bits(1984, number, k));
            write_text(folder / "mutant.vdb", damaged(bytes, dice));
            const auto start = std::chrono::steady_clock::now();
            const std::string what = outcome(folder / "mutant.vdb");
            slowest =
                std::max(slowest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            ++outcomes[what];
        }
    }
    for (const auto& [what, count] : outcomes) {
        RecordProperty(what, count);
        std::printf("%6d %s\n", count, what.c_str());
    }
    std::printf("slowest %.2f s of %zu\n", slowest, each * files.size());
    EXPECT_GT(outcomes["used"], 0);
    EXPECT_GT(outcomes["refused"], 0);
    EXPECT_EQ(folder.list(), (std::vector<std::string>{"mutant.vdb", "seed.vdb"}));
}

}  // namespace
}  // namespace vdbcloud
