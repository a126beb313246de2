#include "vdbcloud/file/input_bytes.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/header.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace vdbcloud {

namespace {

/// The folder for temporary files, as TMPDIR names it.
std::string temporary_folder()
{
    const char* named = std::getenv("TMPDIR");
    return named && *named ? named : "/tmp";
}

/// Opens an unlinked temporary file, which exists until the descriptor is closed. -1 and errno without room for it.
int anonymous_file(const std::string& folder)
{
    std::string name = folder + "/vdbcloud.XXXXXX";
    const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor >= 0) ::unlink(name.c_str());
    return descriptor;
}

bool same_state(const struct stat& a, const struct stat& b)
{
    return a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec && a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

}  // namespace

void InputBytes::fail(const std::string& what) const { throw IoError(printable(path_, 4096) + ": " + what); }

InputBytes::InputBytes(const std::string& path, const Limits& limits) : path_(path)
{
    try {
        open();
        copy(limits);
    } catch (...) {
        if (source_ >= 0) ::close(source_);
        if (kept_ >= 0) ::close(kept_);
        throw;
    }
}

InputBytes::~InputBytes()
{
    if (source_ >= 0) ::close(source_);
    if (kept_ >= 0) ::close(kept_);
}

void InputBytes::open()
{
    if (path_ == "-") {
        if (::isatty(0)) fail("standard input is a terminal: expected a .vdb through a pipe");
        source_ = ::fcntl(0, F_DUPFD_CLOEXEC, 3);  // a duplicate: the guard process replaces descriptors 0..2
    } else {
        source_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    }
    if (source_ < 0) throw IoError(system_message(path_, "cannot read", errno));
}

void InputBytes::copy(const Limits& limits)
{
    struct stat before = {}, after = {};
    if (::fstat(source_, &before) != 0) throw IoError(system_message(path_, "cannot read", errno));
    if (S_ISDIR(before.st_mode)) throw IoError(system_message(path_, "cannot read", EISDIR));
    const off_t at = ::lseek(source_, 0, SEEK_CUR);
    const bool regular = S_ISREG(before.st_mode) && at >= 0;
    const uint64_t start = regular ? uint64_t(at) : 0;
    if (regular) {
        const uint64_t size = uint64_t(std::max<off_t>(before.st_size - at, 0));
        if (size > limits.most) fail(std::to_string(size) + " bytes: expected at most " + std::to_string(limits.most));
        if (!limits.copy && size > limits.in_memory && start == 0) {
            size_ = size;
            std::swap(kept_, source_);
            return;
        }
        if (size <= limits.in_memory) memory_.reserve(size);
    }
    copy_bytes(limits, regular, start);
    if (!regular && size_ == 0) fail("nothing came: expected a .vdb (did the program before it in the pipe fail?)");
    if (regular && (::fstat(source_, &after) != 0 || !same_state(before, after)))
        fail("it changed while it was being read: expected a file that no other program is writing");
}

void InputBytes::copy_bytes(const Limits& limits, bool regular, uint64_t start)
{
    std::vector<char> part(1 << 20);
    for (size_t held = 0;;) {
        char* to = part.data() + held;
        const size_t room = part.size() - held;
        const ssize_t n = regular ? ::pread(source_, to, room, off_t(start + size_ + held)) : ::read(source_, to, room);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw IoError(system_message(path_, "cannot read", errno));
        held += size_t(n);
        if (n > 0 && held < 4) continue;
        if (size_ == 0 && held >= 4 && !has_magic(part.data())) fail(wrong_magic);  // before all of a wrong input
        keep(part.data(), held, limits.in_memory);
        held = 0;
        if (n == 0) break;
        if (size_ > limits.most) fail("expected at most " + std::to_string(limits.most) + " bytes");
    }
}

void InputBytes::keep(const char* bytes, size_t count, uint64_t in_memory)
{
    if (kept_ < 0 && size_ + count > in_memory) spill();
    if (kept_ < 0) memory_.insert(memory_.end(), bytes, bytes + count);
    for (size_t done = 0; kept_ >= 0 && done < count;) {
        const ssize_t n = ::write(kept_, bytes + done, count - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            throw IoError(system_message(path_, "cannot be kept in a temporary file in " + temporary_folder(), errno) +
                          ": set TMPDIR to a folder with more room");
        done += size_t(n);
    }
    size_ += count;
}

/// Moves what is in memory into a temporary file, which takes what follows, too.
void InputBytes::spill()
{
    const std::string folder = temporary_folder();
    kept_ = anonymous_file(folder);
    if (kept_ < 0)
        throw IoError(system_message(path_, "cannot be kept in a temporary file in " + printable(folder, 4096), errno) +
                      ": set TMPDIR to a folder with room");
    const std::vector<char> held = std::move(memory_);
    memory_ = {};
    size_ = 0;
    keep(held.data(), held.size(), 0);
}

ReadAt InputBytes::reader() const
{
    if (kept_ >= 0) return reader_of(kept_);
    return [this](void* to, size_t count, uint64_t offset) -> size_t {
        if (offset >= memory_.size()) return 0;
        const size_t n = std::min<uint64_t>(count, memory_.size() - offset);
        std::memcpy(to, memory_.data() + offset, n);
        return n;
    };
}

}  // namespace vdbcloud
