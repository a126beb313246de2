// A file is read once: what the guard process proves is what the caller gets, whatever others do to the file meanwhile.
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"

#include "support/grids.h"
#include "support/redirect.h"
#include "support/run.h"
#include "support/size.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace vdbcloud {
namespace {

using namespace test;

std::string digest_of(const GridFile& file) { return grid_digest(static_cast<const FloatGrid&>(*file.grids.at(0))); }

/// Sets a variable of the environment until the end of its life.
class Variable {
public:
    Variable(const char* name, const std::string& value) : name_(name)
    {
        if (const char* before = std::getenv(name)) before_ = before;
        ::setenv(name, value.c_str(), 1);
    }
    ~Variable() { before_.empty() ? ::unsetenv(name_) : ::setenv(name_, before_.c_str(), 1); }

private:
    const char* name_;
    std::string before_;
};

/// Another process, which runs `work` and whose exit status is what `work` returns.
class Other {
public:
    explicit Other(const std::function<int()>& work) : process_(::fork())
    {
        if (process_ == 0) ::_exit(work());
    }
    int wait()
    {
        int status = -1;
        ::waitpid(process_, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    void stop() { ::kill(process_, SIGKILL); }

private:
    pid_t process_;
};

void overwrite(const std::string& path, const std::string& bytes)
{
    const int file = ::open(path.c_str(), O_WRONLY);
    if (::pwrite(file, bytes.data(), bytes.size(), 0) < 0 || ::ftruncate(file, off_t(bytes.size())) != 0) ::_exit(9);
    ::close(file);
}

TEST(Changing, AFileRewrittenBetweenGuardAndUseIsReadAsItWas)
{
    const Scratch folder;
    const std::string path = folder / "a.vdb";
    write_grid_file(path, file_of({ball("density", 60)}));
    const std::string before = read_text(path), digest = digest_of(read_grid_file(path));
    // The body becomes 0xff: a reader of it allocates and copies by lengths of 4 GB.
    std::string damaged = before;
    std::fill(damaged.begin() + 400, damaged.end(), '\xff');
    const std::string children =
        "/proc/" + std::to_string(::getpid()) + "/task/" + std::to_string(::getpid()) + "/children";
    Other writer([&] {
        const std::string own = std::to_string(::getpid());
        for (int k = 0; k < 20000; ++k, ::usleep(500)) {
            std::ifstream list(children);
            for (std::string child; list >> child;)
                if (child != own) return overwrite(path, damaged), 0;  // the guard process is at work
        }
        return 1;
    });
    ReadCost cost;
    std::string read;
    EXPECT_EQ(sentence<IoError>([&] { read = digest_of(read_grid_file(path, {}, &cost)); }), "");
    EXPECT_EQ(writer.wait(), 0) << "the file was not rewritten while the guard process was there";
    EXPECT_EQ(read_text(path), damaged);
    EXPECT_EQ(read, digest);
    EXPECT_EQ(cost.bytes, before.size());
}

TEST(Changing, AFileThatIsWrittenAllTheTimeIsReadWholeOrRefused)
{
    const Scratch folder;
    const std::string path = folder / "a.vdb";
    std::string bytes[2], digests[2];
    for (const int k : {0, 1}) {
        write_grid_file(path, file_of({ball("density", 12 + 12 * k)}));
        bytes[k] = read_text(path);
        ReadCost cost;
        read_grid_file(path, {}, &cost);
        digests[k] = cost.digest;
    }
    Other writer([&] {
        for (int k = 0;; k = 1 - k, ::usleep(100)) overwrite(path, bytes[k]);
        return 0;
    });
    for (int k = 0; k < sized(40, 1000); ++k) {
        ReadCost cost;
        const std::string refused = sentence<IoError>([&] { read_grid_file(path, {}, &cost); });
        if (!refused.empty()) {
            EXPECT_EQ(refused.find(path + ": "), 0u) << refused;
        } else {
            EXPECT_TRUE(cost.digest == digests[0] || cost.digest == digests[1] || cost.bytes > 0);
        }
    }
    writer.stop();
    writer.wait();
}

TEST(Changing, ACopyAboveTheLimitIsInAnUnlinkedTemporaryFile)
{
    const Scratch folder, temporary;
    const std::string path = folder / "a.vdb";
    write_grid_file(path, file_of({ball("density", 20)}));
    ReadCost in_memory, in_file;
    const std::string digest = digest_of(read_grid_file(path, {}, &in_memory));
    ReadOptions small;
    small.memory_bytes = 1000;
    {
        const Variable folder_of_copies("TMPDIR", temporary.path());
        EXPECT_EQ(digest_of(read_grid_file(path, small, &in_file)), digest);
        with_input(read_text(path), [&] { EXPECT_EQ(digest_of(read_grid_file("-", small)), digest); });
    }
    EXPECT_EQ(in_file.digest, in_memory.digest);
    EXPECT_EQ(in_file.bytes, in_memory.bytes);
    // The copy goes on in a file where memory is full: bytes before and after that point are there.
    WriteOptions plain;
    plain.compression = Compression::None;
    write_grid_file(folder / "large.vdb", file_of({ball("density", 60)}), plain);
    ReadOptions middle;
    middle.memory_bytes = 3 << 19;  // a part of 1 MiB fits, two do not
    EXPECT_GT(read_text(folder / "large.vdb").size(), 2 * middle.memory_bytes);
    EXPECT_EQ(digest_of(read_grid_file(folder / "large.vdb", middle)), digest_of(read_grid_file(folder / "large.vdb")));
    EXPECT_EQ(temporary.list(), std::vector<std::string>());
    const Variable nowhere("TMPDIR", temporary / "none");
    EXPECT_EQ(digest_of(read_grid_file(path)), digest) << "needs no temporary file";
    for (const bool piped : {false, true}) {
        const std::string said = sentence<IoError>([&] {
            if (piped) with_input(read_text(path), [&] { read_grid_file("-", small); });
            if (!piped) read_grid_file(path, small);
        });
        EXPECT_NE(said.find(temporary / "none"), std::string::npos) << said;
        EXPECT_NE(said.find("set TMPDIR"), std::string::npos) << said;
    }
    small.trust = true;
    EXPECT_EQ(digest_of(read_grid_file(path, small)), digest) << "a trusted file is read in place";
}

TEST(Changing, NoRoomForTheCopyIsSaidAsSuch)
{
    const Scratch folder;
    const std::string path = folder / "a.vdb";
    write_grid_file(path, file_of({ball("density", 20)}));
    ReadOptions small;
    small.memory_bytes = 1000;
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit before = {};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit little = {4096, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &little);  // as a full disk, in the middle of the copy
    const std::string said = sentence<IoError>([&] { read_grid_file(path, small); });
    const std::string fits = sentence<IoError>([&] { read_grid_file(path); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_NE(said.find("cannot be kept in a temporary file"), std::string::npos) << said;
    EXPECT_NE(said.find("File too large: set TMPDIR to a folder with more room"), std::string::npos) << said;
    EXPECT_EQ(fits, "");
}

}  // namespace
}  // namespace vdbcloud
