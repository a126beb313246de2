// Failed reads and writes give one sentence that begins with the path, and leave no temporary files.
#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/guard.h"
#include "vdbcloud/file/header.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/registry.h"

#include "support/grids.h"
#include "support/run.h"

#include <openvdb/io/Stream.h>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

/// The error message of a failed read, without the path. Checks that the message begins with the path and is one line.
std::string refusal(const std::string& path, const ReadOptions& options = {})
{
    const std::string said = sentence<IoError>([&] { read_grid_file(path, options); });
    EXPECT_EQ(said.find(path + ": "), 0u) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    return said.substr(std::min(said.size(), path.size() + 2));
}

std::string write_refusal(const std::string& path, const GridFile& file, const WriteOptions& options = {})
{
    const std::string said = sentence<IoError>([&] { write_grid_file(path, file, options); });
    EXPECT_EQ(said.find(path + ": "), 0u) << said;
    return said.substr(std::min(said.size(), path.size() + 2));
}

/// Writes the grid with OpenVDB's own writer, which accepts invalid grids. Returns the path.
std::string saved(const Scratch& folder, const GridBasePtr& grid)
{
    openvdb::initialize();
    std::ofstream stream(folder / "a.vdb", std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridPtrVec{grid});
    return folder / "a.vdb";
}

/// Writes a file whose metadata vdbcloud:format is `format`, with OpenVDB's own writer. Returns the path.
template<typename T>
std::string saved_as_format(const Scratch& folder, const T& format)
{
    openvdb::initialize();
    openvdb::MetaMap metadata;
    metadata.insertMeta(schema::format, openvdb::TypedMetadata<T>(format));
    std::ofstream stream(folder / "a.vdb", std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridPtrVec{ball("density")}, metadata);
    return folder / "a.vdb";
}

/// Voxels of 5e-7 x 1 x 1 world units.
Transform::Ptr thin()
{
    openvdb::Mat4d scale = openvdb::Mat4d::identity();
    scale.preScale(Vec3d(5e-7, 1, 1));
    return Transform::createLinearTransform(scale);
}

TEST(Reading, RefusesPathsThatAreNotVdbFiles)
{
    const Scratch folder;
    EXPECT_EQ(refusal(folder / "missing.vdb"), "cannot read: No such file or directory");
    EXPECT_EQ(refusal(folder.path()), "cannot read: Is a directory");
    write_text(folder / "empty.vdb", "");
    EXPECT_EQ(refusal(folder / "empty.vdb"), "expected a .vdb, found only 0 bytes");
    write_text(folder / "text.vdb", "a text that is longer than a header\n");
    EXPECT_EQ(refusal(folder / "text.vdb"), wrong_magic);
    EXPECT_EQ(refusal("/dev/zero"), wrong_magic);
    EXPECT_EQ(refusal("/dev/null").find("nothing came"), 0u);
}

TEST(Reading, RefusesTruncatedFiles)
{
    const Scratch folder;
    write_grid_file(folder / "whole.vdb", file_of({ball("density"), ball("heat")}));
    const std::string bytes = read_text(folder / "whole.vdb");
    for (size_t size = 8; size < bytes.size(); size += size < 1000 ? 37 : bytes.size() / 50) {
        write_text(folder / "cut.vdb", bytes.substr(0, size));
        EXPECT_NE(refusal(folder / "cut.vdb").find("ends too early"), std::string::npos) << size;
    }
    write_text(folder / "cut.vdb", bytes.substr(0, bytes.size() - 1));
    EXPECT_NE(refusal(folder / "cut.vdb").find("ends too early"), std::string::npos);
}

TEST(Reading, HeaderCheckDetectsTruncation)
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file_of({ball("density"), ball("heat")}));
    const std::string bytes = read_text(folder / "a.vdb");
    write_text(folder / "a.vdb", bytes.substr(0, bytes.size() - 1));
    const int descriptor = ::open((folder / "a.vdb").c_str(), O_RDONLY);
    const auto said = sentence<IoError>([&] { check_header("a.vdb", reader_of(descriptor), bytes.size() - 1); });
    EXPECT_NE(said.find("ends too early: grid 'heat' reaches to byte"), std::string::npos) << said;
    ::close(descriptor);
}

TEST(Reading, RefusesANewerFormatVersion)
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file_of({ball("density")}));
    std::string bytes = read_text(folder / "a.vdb");
    bytes[8] = char(225);
    write_text(folder / "a.vdb", bytes);
    EXPECT_EQ(refusal(folder / "a.vdb").find(".vdb format 225: expected 224 or older"), 0u);
}

TEST(Reading, RefusesANewerNumberOfOurOwnFormat)
{
    const Scratch folder;
    for (const double former : {1.0, 2.0})
        EXPECT_EQ(read_grid_file(saved_as_format(folder, former)).grids.size(), 1u) << former;
    EXPECT_EQ(refusal(saved_as_format(folder, 3.0)),
              "metadata 'vdbcloud:format' = 3: expected 1 to 2: a newer vdbcloud wrote this file, update vdbcloud to "
              "read it");
    EXPECT_NE(refusal(saved_as_format(folder, int32_t(7))).find("= 7: expected 1 to 2: a newer"), std::string::npos);
    EXPECT_EQ(refusal(saved_as_format(folder, 0.0)), "metadata 'vdbcloud:format' = 0: expected 1 to 2");
    EXPECT_EQ(refusal(saved_as_format(folder, std::string("two"))),
              "metadata 'vdbcloud:format' = two: expected a finite number");
}

TEST(Reading, RefusesSingularNonFiniteAndOutOfRangeTransforms)
{
    const Scratch folder;
    const auto grid = ball("density");
    grid->setTransform(thin());
    EXPECT_NE(refusal(saved(folder, grid)).find("voxel edge 5e-07: expected 1e-6 to 1e6"), std::string::npos);
    grid->setTransform(Transform::createLinearTransform(1e7));
    EXPECT_NE(refusal(saved(folder, grid)).find("voxel edge 1e+07"), std::string::npos);
    openvdb::Mat4d shear = openvdb::Mat4d::identity();
    shear(1, 0) = 1e3;
    grid->setTransform(Transform::createLinearTransform(shear));
    EXPECT_NO_THROW(read_grid_file(saved(folder, grid))) << "a shear is no fault in itself";
    shear(1, 0) = 1, shear(1, 1) = 1e-10;  // two edges almost parallel
    grid->setTransform(Transform::createLinearTransform(shear));
    EXPECT_NE(refusal(saved(folder, grid)).find("flat"), std::string::npos);

    const double marked = 12345.678, nan = NAN;
    const auto moved = Transform::createLinearTransform(1.0);
    moved->postTranslate(Vec3d(0, marked, 0));
    grid->setTransform(moved);
    std::string bytes = read_text(saved(folder, grid));
    const std::string pattern(reinterpret_cast<const char*>(&marked), sizeof marked);
    ASSERT_NE(bytes.find(pattern), std::string::npos);
    bytes.replace(bytes.find(pattern), sizeof nan, reinterpret_cast<const char*>(&nan), sizeof nan);
    write_text(folder / "nan.vdb", bytes);
    ReadOptions trusting;
    trusting.trust = true;
    for (const auto& options : {ReadOptions(), trusting}) {
        const std::string said = refusal(folder / "nan.vdb", options);
        EXPECT_NE(said.find("not finite"), std::string::npos) << said;
    }
}

TEST(Reading, RefusesMoreVoxelsAndLargerCoordinatesThanTheLimits)
{
    const Scratch folder;
    const auto grid = FloatGrid::create(0.0f);
    grid->setName("density");
    grid->tree().addTile(3, Coord(0), 1.0f, true);  // 4096^3 voxels in one tile
    EXPECT_NE(refusal(saved(folder, grid)).find("68719476736 active voxels: expected at most 2^31"), std::string::npos);
    grid->clear();
    grid->tree().setValue(Coord(1 << 30, 0, 0), 1.0f);
    EXPECT_NE(refusal(saved(folder, grid)).find("coordinates below 2^30"), std::string::npos);
    grid->clear();
    grid->tree().setValue(Coord((1 << 30) - 1, 0, 0), 1.0f);
    EXPECT_EQ(read_grid_file(saved(folder, grid)).grids.size(), 1u);
}

TEST(Reading, ShortensAndSanitisesTextFromTheFile)
{
    const Scratch folder;
    const auto grid = ball("bad\x1b[31m\nname" + std::string(5000, 'x'));
    grid->setTransform(thin());
    const std::string said = refusal(saved(folder, grid));
    EXPECT_LT(said.size(), 400u);
    EXPECT_EQ(said.find('\x1b'), std::string::npos);
}

TEST(Guard, ReportsReturnExceptionSignalAndLimits)
{
    const GuardLimits limits{uint64_t(256) << 20, 1.0};
    EXPECT_EQ(run_guarded([] {}, limits), "");
    EXPECT_EQ(run_guarded([] { throw IoError("x.vdb: no"); }, limits), "x.vdb: no");
    EXPECT_EQ(run_guarded([] { std::abort(); }, limits), "malformed: it breaks the reader (signal 6)");
    EXPECT_EQ(run_guarded([] { ::raise(SIGSEGV); }, limits), "malformed: it breaks the reader (signal 11)");
    EXPECT_NE(run_guarded(
                  [] {
                      for (volatile unsigned k = 0;; k = k + 1) {
                      }
                  },
                  limits)
                  .find("more than 1 s of processor time"),
              std::string::npos);
#if !defined(__SANITIZE_ADDRESS__)
    EXPECT_NE(run_guarded([] { std::string(size_t(1) << 30, 'x'); }, limits).find("more than 256 MB of memory"),
              std::string::npos);
#endif
}

TEST(Guard, DoesNotDestroyObjectsOfTheWork)
{
    struct Stuck {
        ~Stuck() { ::pause(); }
    };
    const GuardLimits limits{uint64_t(256) << 20, 1.0};
    EXPECT_EQ(run_guarded(
                  [] {
                      const Stuck stuck;
                      throw InputError("as it should");
                  },
                  limits),
              "as it should");
}

TEST(Writing, ReportsAFullDisk)
{
    EXPECT_EQ(write_refusal("/dev/full", file_of({ball("density")})), "cannot write: No space left on device");
    EXPECT_EQ(write_refusal("/dev/full", file_of({ball("density", 60)})), "cannot write: No space left on device")
        << "more than one buffer";
    struct stat status = {};
    ASSERT_EQ(::stat("/dev/full", &status), 0);
    EXPECT_TRUE(S_ISCHR(status.st_mode)) << "the device is still there";
}

TEST(Writing, RefusesFoldersAndLeavesNoFile)
{
    const Scratch folder;
    const auto file = file_of({ball("density")});
    EXPECT_EQ(write_refusal(folder.path(), file), "cannot write: Is a directory");
    EXPECT_EQ(write_refusal(folder / "no/such/a.vdb", file),
              "cannot write: there is no folder " + (folder / "no/such"));
    write_text(folder / "plain", "x");
    EXPECT_EQ(write_refusal(folder / "plain/a.vdb", file).find("cannot write: "), 0u);
    EXPECT_EQ(folder.list(), std::vector<std::string>{"plain"});
}

TEST(Writing, FailureKeepsTheOldFile)
{
    const Scratch folder;
    write_grid_file(folder / "a.vdb", file_of({ball("density")}));
    const std::string before = read_text(folder / "a.vdb");
    const auto bright = ball("density");
    bright->tree().setValue(Coord(1, 2, 3), 65505.0f);
    WriteOptions half;
    half.half = true;
    const auto said = sentence<InputError>([&] { write_grid_file(folder / "a.vdb", file_of({bright}), half); });
    EXPECT_EQ(said, "grid 'density': value 65505 at [1, 2, 3]: expected at most 65504 to store it as half");
    WriteOptions keep;
    keep.no_clobber = true;
    EXPECT_EQ(write_refusal(folder / "a.vdb", file_of({bright}), keep), "file exists and --no-clobber was given");
    EXPECT_EQ(read_text(folder / "a.vdb"), before);
    EXPECT_EQ(folder.list(), std::vector<std::string>{"a.vdb"});
    EXPECT_NO_THROW(write_grid_file(folder / "b.vdb", file_of({bright}), keep));
}

TEST(Writing, FollowsLinksAndKeepsPermissions)
{
    const Scratch folder;
    write_text(folder / "real.vdb", "old");
    ASSERT_EQ(::chmod((folder / "real.vdb").c_str(), 0640), 0);
    ASSERT_EQ(::symlink("real.vdb", (folder / "link.vdb").c_str()), 0);
    write_grid_file(folder / "link.vdb", file_of({ball("density")}));
    struct stat status = {};
    ASSERT_EQ(::lstat((folder / "link.vdb").c_str(), &status), 0);
    EXPECT_TRUE(S_ISLNK(status.st_mode));
    ASSERT_EQ(::stat((folder / "real.vdb").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0640u);
    EXPECT_EQ(read_grid_file(folder / "real.vdb").grids.size(), 1u);

    write_grid_file(folder / "new.vdb", file_of({ball("density")}));
    ASSERT_EQ(::stat((folder / "new.vdb").c_str(), &status), 0);
    const mode_t mask = ::umask(0);
    ::umask(mask);
    EXPECT_EQ(status.st_mode & 0777, 0666u & ~mask);
}

TEST(Writing, WritesToAFifo)
{
    const Scratch folder;
    ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
    std::thread writer([&] { write_grid_file(folder / "fifo", file_of({ball("density", 30)})); });
    const auto file = read_grid_file(folder / "fifo");
    writer.join();
    EXPECT_EQ(file.grids.size(), 1u);
    struct stat status = {};
    ASSERT_EQ(::stat((folder / "fifo").c_str(), &status), 0);
    EXPECT_TRUE(S_ISFIFO(status.st_mode));
}

TEST(Writing, RemovesTemporariesWithoutCommitAndOnInterrupt)
{
    const Scratch folder;
    {
        const AtomicFile given_up(folder / "a.vdb");
        EXPECT_EQ(folder.list().size(), 1u);
        EXPECT_EQ(folder.list()[0].substr(0, 3), ".a.");
        EXPECT_EQ(std::filesystem::path(given_up.name()).extension(), ".vdb");
    }
    EXPECT_TRUE(folder.list().empty());
    AtomicFile one(folder / "b.exr"), two(folder / "c");
    EXPECT_EQ(folder.list().size(), 2u);
    remove_temporaries();
    EXPECT_TRUE(folder.list().empty());
}

TEST(Writing, RefusesFilesBeyondTheTableOfTemporaries)
{
    const Scratch folder;
    std::vector<std::unique_ptr<AtomicFile>> files;
    const auto said = sentence<IoError>([&] {
        for (int k = 0; k < 1000; ++k) files.push_back(std::make_unique<AtomicFile>(folder / std::to_string(k)));
    });
    EXPECT_NE(said.find("too many files"), std::string::npos) << said;
    files.clear();
    EXPECT_TRUE(folder.list().empty());
    EXPECT_NO_THROW(AtomicFile(folder / "again"));
}

}  // namespace
}  // namespace vdbcloud
