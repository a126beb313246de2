// Metadata of vdbcloud's own that no program wrote: each key, with another type and with impossible numbers, ends as a
// sentence or leaves a picture that can be right. Metadata of other programs under a common name is passed over.
#include "stages.h"

#include "support/size.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <cmath>
#include <limits>

namespace vdbcloud::test {
namespace {

using openvdb::Metadata;

/// Values that a row of the table does not have: another type, and numbers that are none, vast, or just out of range.
std::vector<Metadata::Ptr> hostile(const schema::MetaKey& key)
{
    const std::string type = key.type;
    std::vector<Metadata::Ptr> values;
    if (type == "string") {
        values.push_back(openvdb::DoubleMetadata(1).copy());
        for (const char* text : {"", "nan 1 1", "1 1e999", "-7", "xyzzy; \x1b[2J"})
            values.push_back(openvdb::StringMetadata(text).copy());
        return values;
    }
    values.push_back(openvdb::StringMetadata("much").copy());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double x : {nan, inf, 1e300, -1e300, -1.0, key.range.least - 0.5, key.range.greatest * 2, 1e9}) {
        values.push_back(type == "double" ? openvdb::DoubleMetadata(x).copy()
                                          : openvdb::Vec3DMetadata(Vec3d(x)).copy());
        if (type == "vec3d") values.push_back(openvdb::Vec3DMetadata(Vec3d(0.5, x, 0.5)).copy());
    }
    return values;
}

class HostileMetadata : public Stages {
protected:
    /// The file with one value changed.
    std::string spoilt(const std::string& path, const std::string& grid, const std::string& key, const Metadata& value)
    {
        GridFile file = read_grid_file(path);
        MetaMap& to = grid.empty() ? *file.metadata : static_cast<MetaMap&>(*find_grid(file, grid));
        to.removeMeta(key);
        to.insertMeta(key, value);
        write_grid_file(scratch / "spoilt.vdb", file);
        return scratch / "spoilt.vdb";
    }
    RunResult render(const std::string& input, const Words& options)
    {
        return run(test::with(
            {program("render"), input, "-o", scratch / "p.exr", "--resolution", "4", "--threads", "1"}, options));
    }
    /// Values of the picture that are not finite or below 0 by more than float's rounding of a sum.
    int impossible()
    {
        int count = 0;
        for (const float x : test::picture(scratch / "p.exr").pixels) count += !(x >= 0 && std::isfinite(x));
        return count;
    }
    /// Spoils each key of each grid of the file in each way, every `stride`-th of them.
    void spoil(const std::string& path, const Words& options, int stride, int& tried, int& refused)
    {
        int turn = 0;
        for (const GridBasePtr& grid : read_grid_file(path).grids)
            for (const schema::MetaKey& key : schema::meta_keys()) {
                if (!key.ours() || !has_meta(*grid, key.key)) continue;
                for (const Metadata::Ptr& value : hostile(key)) {
                    if (turn++ % stride != 0) continue;
                    ++tried;
                    SCOPED_TRACE(grid->getName() + " " + key.key + " = " + value->str());
                    const RunResult result = render(spoilt(path, grid->getName(), key.key, *value), options);
                    if (result.status == 0) {
                        EXPECT_EQ(impossible(), 0);
                        continue;
                    }
                    ++refused;
                    EXPECT_TRUE(result.status >= 1 && result.status <= 3) << result.status;
                    EXPECT_NE(result.err.find("spoilt.vdb: "), std::string::npos) << result.err;
                    EXPECT_EQ(result.err.find('\x1b'), std::string::npos);
                }
            }
    }
};

TEST_F(HostileMetadata, IsRefusedOrLeavesAPossiblePicture)
{
    const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const Words medium{"--extinction", "0.4", "--albedo", "0.9", "--g", "0.6", "--sun", "0,1,0"};
    const std::string swept =
        stage("p1solve", input, "swept.vdb",
              test::with(medium, {"--sky", "0.5", "--iterations", "1", "--directions", "8", "--degree", "2"}));
    const std::string series =
        stage("p1solve", input, "series.vdb", test::with(medium, {"--series", "2", "--galerkin"}));
    int tried = 0, refused = 0;
    spoil(swept, {}, sized(211, 19), tried, refused);
    spoil(series, {"--albedo", "0.8"}, sized(113, 19), tried, refused);
    EXPECT_GE(tried, sized(12, 120));
    EXPECT_GE(refused, tried / 5) << "of " << tried;
}

TEST_F(HostileMetadata, NamesFileGridKeyValueAndRange)
{
    const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME);
    const std::string lit = stage("p1solve", input, "lit.vdb", {"--extinction", "0.4", "--g", "0.6", "--sun", "0,1,0"});
    struct Row {
        const char *grid, *key;
        Metadata::Ptr value;
        const char* sentence;
    };
    const Row rows[] = {
        {"phi", schema::degree, openvdb::DoubleMetadata(1e300).copy(), "expected a whole number in [1, 100]"},
        {"phi", schema::delta_f, openvdb::DoubleMetadata(-1).copy(), "= -1: expected a number in [0, 0.9"},
        {"phi", schema::channel_scale, openvdb::Vec3DMetadata(Vec3d(1, -1, 1)).copy(), "three numbers in [0, 1e+30]"},
        {"phi", schema::scaled_moments, openvdb::StringMetadata("1 2").copy(), "expected 1 and 1 numbers in [-1, 1]"},
        {"density", schema::albedo, openvdb::StringMetadata("white").copy(),
         "= white: expected three numbers in [0, 1]"},
    };
    for (const Row& row : rows) {
        const RunResult result = render(spoilt(lit, row.grid, row.key, *row.value), {});
        EXPECT_EQ(result.status, 1);
        EXPECT_EQ(
            result.err.rfind("render: " + scratch / "spoilt.vdb: grid '" + row.grid + "': metadata '" + row.key, 0), 0u)
            << result.err;
        EXPECT_NE(result.err.find(row.sentence), std::string::npos) << result.err;
    }
}

/// Each program that reads grids says so once and goes on, as if the key were not there.
TEST_F(HostileMetadata, OfOtherProgramsIsPassedOverWithANote)
{
    GridFile file = file_of({ball("density", 5)});
    MetaMap& metadata = *file.metadata;
    metadata.insertMeta(schema::creator, openvdb::DoubleMetadata(7));
    metadata.insertMeta(schema::history, openvdb::BoolMetadata(true));
    metadata.insertMeta(schema::up_axis, openvdb::StringMetadata("skywards"));
    metadata.insertMeta(schema::meters_per_unit, openvdb::DoubleMetadata(-3));
    write_grid_file(scratch / "foreign.vdb", file);
    const std::string in = scratch / "foreign.vdb";
    const std::vector<Words> commands = {
        {program("illuminate"), in, "--extinction", "1", "-o", scratch / "i.vdb"},
        {program("p1solve"), in, "--extinction", "1", "-o", scratch / "p.vdb"},
        {program("render"), in, "--extinction", "1", "-o", scratch / "p.exr", "--resolution", "4"},
        {program("fractalgen"), "--envelope-from", in, "--size", "8", "-o", scratch / "f.vdb"},
        {program("vdbdiff"), in, in},
        {program("vdbprobe"), in, "--grid", "density", "--at", "0,0,0"}};
    for (const Words& command : commands) {
        const RunResult result = run(command);
        EXPECT_EQ(result.status, 0) << command[0] << ": " << result.err;
        for (const char* key : {"creator' = 7 ", "history' = true ", "up_axis' = skywards ", "meters_per_unit' = -3 "})
            EXPECT_NE(result.err.find("metadata '" + std::string(key) + "is passed over: expected "), std::string::npos)
                << command[0] << ": " << key << ": " << result.err;
    }
    EXPECT_EQ(get_text(*read_grid_file(scratch / "p.vdb").metadata, schema::creator, "").rfind("p1solve", 0), 0u);
}

}  // namespace
}  // namespace vdbcloud::test
