// Reading and writing through pipes: path "-" is standard input and output.
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"

#include "support/grids.h"
#include "support/redirect.h"
#include "support/run.h"

#include <gtest/gtest.h>

#include <csignal>

namespace vdbcloud {
namespace {

using namespace test;

std::string piped(const GridFile& file)
{
    return output_of([&] { write_grid_file("-", file); });
}

GridFile read_piped(const std::string& bytes, const ReadOptions& options = {})
{
    GridFile file;
    with_input(bytes, [&] { file = read_grid_file("-", options); });
    return file;
}

TEST(Pipe, RoundTripKeepsGridsAndMetadata)
{
    auto file = file_of({ball("density", 40), ball("temperature", 5), FloatGrid::create(1.0f)});
    set_text(*file.metadata, "history", "a line");
    const std::string bytes = piped(file);
    EXPECT_GT(bytes.size(), 70000u) << "more than a pipe holds, so that both ends have to work";
    auto back = read_piped(bytes);
    EXPECT_EQ(back.path, "-");
    ASSERT_EQ(back.grids.size(), 3u);
    EXPECT_EQ(get_text(*back.metadata, "history", ""), "a line");
    for (size_t k = 0; k < 3; ++k)
        EXPECT_EQ(grid_digest(static_cast<FloatGrid&>(*back.grids[k])),
                  grid_digest(static_cast<FloatGrid&>(*file.grids[k])));
}

TEST(Pipe, EqualGridsGiveEqualBytesAndChangedGridsANewIdentifier)
{
    const std::string a = piped(file_of({ball("density")}));
    EXPECT_EQ(a, piped(file_of({ball("density")})));
    EXPECT_NE(a.substr(21, 36), piped(file_of({ball("density", 10)})).substr(21, 36));
    const auto other = ball("density");
    other->tree().setValueOn(openvdb::Coord(0), 0.5f);
    EXPECT_NE(a.substr(21, 36), piped(file_of({other})).substr(21, 36)) << "another value in one voxel";
}

TEST(Pipe, AcceptsFileLayoutAndRedirection)
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file_of({ball("density")}));
    ReadCost from_pipe, from_file;
    with_input(read_text(folder / "a.vdb"), [&] { read_grid_file("-", {}, &from_pipe); });
    read_grid_file(folder / "a.vdb", {}, &from_file);
    EXPECT_EQ(from_pipe.digest, from_file.digest);
    EXPECT_EQ(from_pipe.bytes, from_file.bytes);

    // Redirected from a file, standard input needs no temporary copy.
    const Redirect redirect(0, ::open((folder / "a.vdb").c_str(), O_RDONLY));
    EXPECT_EQ(read_grid_file("-").grids.size(), 1u);
}

TEST(Pipe, StreamSavedToAFileIsReadable)
{
    const Scratch folder;
    write_text(folder / "a.vdb", piped(file_of({ball("density"), ball("heat")})));
    EXPECT_EQ(read_grid_file(folder / "a.vdb").grids.size(), 2u);
}

TEST(Pipe, RefusesATruncatedStream)
{
    const std::string bytes = piped(file_of({ball("density", 30)}));
    EXPECT_EQ(sentence<IoError>([&] { read_piped(""); }).find("-: nothing came"), 0u);
    EXPECT_EQ(sentence<IoError>([&] { read_piped("hello, world"); }).find("-: not a .vdb"), 0u);
    EXPECT_EQ(sentence<IoError>([&] { read_piped(bytes.substr(0, 3)); }).find("-: "), 0u);
    for (const double part : {0.001, 0.02, 0.5, 0.9, 0.999}) {
        const std::string said =
            sentence<IoError>([&] { read_piped(bytes.substr(0, size_t(part * double(bytes.size())))); });
        EXPECT_NE(said.find("ends too early"), std::string::npos) << part << ": " << said;
    }
}

TEST(Pipe, RefusesMoreThanMaxBytes)
{
    ReadOptions options;
    options.max_bytes = 1000;
    const std::string bytes = piped(file_of({ball("density", 30)}));
    EXPECT_NE(sentence<IoError>([&] { read_piped(bytes, options); }).find("at most 1000 bytes"), std::string::npos);
}

TEST(Pipe, ClosedReaderIsAnIoErrorIfSigpipeIsIgnored)
{
    const auto before = std::signal(SIGPIPE, SIG_IGN);
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    ::close(ends[0]);
    std::string said;
    {
        const Redirect redirect(1, ends[1]);
        said = sentence<IoError>([&] { write_grid_file("-", file_of({ball("density")})); });
    }
    std::signal(SIGPIPE, before);
    EXPECT_EQ(said, "standard output: cannot write: Broken pipe");
}

TEST(Pipe, IgnoresBytesAfterTheLastGridWithAWarning)
{
    std::string said;
    ReadOptions options;
    options.warn = [&](const std::string& s) { said += s; };
    const auto file = read_piped(piped(file_of({ball("density")})) + "trailing", options);
    EXPECT_EQ(file.grids.size(), 1u);
    EXPECT_NE(said.find("8 bytes behind the last grid"), std::string::npos) << said;
}

}  // namespace
}  // namespace vdbcloud
