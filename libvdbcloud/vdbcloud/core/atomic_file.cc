#include "vdbcloud/core/atomic_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace vdbcloud {

namespace {

namespace fs = std::filesystem;

// A signal handler may read the slots at any time. So a slot's path is complete before its state is Live, and the
// array never moves in memory.
struct Slot {
    enum State { Free, Filling, Live };
    std::atomic<int> state{Free};
    char path[4096];
};
Slot slots[64];
static_assert(std::atomic<int>::is_always_lock_free);

/// Registers a file for remove_temporaries(). Returns its slot; -1 if the table is full or the path is too long.
int remember(const std::string& path)
{
    if (path.size() >= sizeof(Slot::path)) return -1;
    for (int k = 0; k < int(std::size(slots)); ++k) {
        int free = Slot::Free;
        if (!slots[k].state.compare_exchange_strong(free, Slot::Filling)) continue;
        std::memcpy(slots[k].path, path.c_str(), path.size() + 1);
        slots[k].state = Slot::Live;
        return k;
    }
    return -1;
}

}  // namespace

std::string link_target(const std::string& name)
{
    fs::path path = name;
    std::error_code failed;
    for (int depth = 0; depth < 40 && fs::is_symlink(path, failed); ++depth) {
        const fs::path next = fs::read_symlink(path, failed);
        if (failed) break;
        path = next.is_absolute() ? next : path.parent_path() / next;
    }
    return path.string();
}

std::string temporary_name(const std::string& path)
{
    const fs::path target = path;
    uint64_t bits = 0;
    // Without random numbers of the system the name can be guessed; O_EXCL still keeps it from being anyone's.
    if (::getrandom(&bits, sizeof bits, 0) != sizeof bits) {
        static std::atomic<uint64_t> count{0};
        bits = hash_bits(uint64_t(std::chrono::steady_clock::now().time_since_epoch().count()), uint64_t(getpid()),
                         ++count);
    }
    char random[20];
    std::snprintf(random, sizeof random, "%016llx", static_cast<unsigned long long>(bits));
    // Shorten the stem, so that the temporary's name stays within the system's limit for every valid target name.
    const std::string stem = target.stem().string().substr(0, 160), extension = target.extension().string();
    return (target.parent_path() / ("." + stem + "." + random + extension)).string();
}

std::string system_message(const std::string& path, const std::string& what, int code)
{
    const std::string reason = code == EBADF ? "it is closed" : std::generic_category().message(code);
    return printable(path, 4096) + ": " + what + ": " + reason;
}

AtomicFile::AtomicFile(const std::string& path, bool no_clobber) : path_(path), no_clobber_(no_clobber)
{
    if (path.empty()) throw IoError("'': expected a file name to write to");
    struct stat status = {};
    const bool exists = ::stat(path.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) throw IoError(system_message(path, "cannot write", EISDIR));
    if (exists && !S_ISREG(status.st_mode)) {
        name_ = target_ = path;
        descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) throw IoError(system_message(path, "cannot write", errno));
        return;
    }
    if (exists && no_clobber) throw IoError(printable(path, 4096) + ": file exists and --no-clobber was given");

    const fs::path target = link_target(path), folder = target.has_parent_path() ? target.parent_path() : ".";
    std::error_code failed;
    if (!fs::is_directory(folder, failed))
        throw IoError(printable(path, 4096) + ": cannot write: there is no folder " + printable(folder.string(), 4096));
    if (!target.has_filename()) throw IoError(printable(path, 4096) + ": expected a file name, not a folder");
    target_ = target.string();
    for (int attempt = 0; attempt < 100 && descriptor_ < 0; ++attempt) {
        name_ = temporary_name(target_);
        // Register before the file exists, so that a signal handler never misses the file.
        if (slot_ = remember(name_); slot_ < 0)
            throw IoError(printable(path, 4096) + ": name too long, or too many files being written at once");
        descriptor_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (descriptor_ >= 0) break;
        const int code = errno;
        forget_temporary(/*remove=*/false);
        if (code != EEXIST) throw IoError(system_message(path, "cannot write", code));
    }
    if (descriptor_ < 0) throw IoError(system_message(path, "cannot write", EEXIST));
    (void)!::flock(descriptor_, LOCK_EX | LOCK_NB);                    // best effort: see remove_stale_temporaries()
    if (exists) (void)!::fchmod(descriptor_, status.st_mode & 07777);  // best effort: permissions of the replaced file
}

AtomicFile::~AtomicFile()
{
    if (descriptor_ >= 0) ::close(descriptor_);
    forget_temporary(/*remove=*/true);
}

void AtomicFile::close_descriptor()
{
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0) throw IoError(system_message(path_, "cannot write", errno));
}

void AtomicFile::forget_temporary(bool remove)
{
    if (slot_ < 0) return;
    if (remove) ::unlink(name_.c_str());
    slots[slot_].state = Slot::Free;
    slot_ = -1;
}

void AtomicFile::commit()
{
    // Devices and pipes cannot be synchronised. Their EINVAL, EROFS or ENOTSUP is not a failure.
    if (::fsync(descriptor_) != 0 && (seekable() || (errno != EINVAL && errno != EROFS && errno != ENOTSUP)))
        throw IoError(system_message(path_, "cannot write", errno));
    close_descriptor();
    if (!seekable()) return;

    int failed = no_clobber_ ? ::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, target_.c_str(), RENAME_NOREPLACE)
                             : ::rename(name_.c_str(), target_.c_str());
    if (failed && no_clobber_ && errno == EINVAL) {  // no RENAME_NOREPLACE here; link() does not replace either
        failed = ::link(name_.c_str(), target_.c_str());
        if (!failed) ::unlink(name_.c_str());
    }
    if (failed) throw IoError(system_message(path_, "cannot write", errno));
    forget_temporary(/*remove=*/false);
}

void remove_temporaries() noexcept
{
    for (Slot& slot : slots)
        if (slot.state == Slot::Live) ::unlink(slot.path);
}

void remove_stale_temporaries(const std::string& folder, const std::function<bool(const std::string&)>& ours)
{
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, failed)) {
        // ".STEM.RANDOM.EXTENSION": the extension may be missing
        const std::string name = entry.path().filename().string();
        for (const bool extended : {true, false}) {
            const size_t end = extended ? name.rfind('.') : name.size();
            if (name[0] != '.' || end == std::string::npos || end < 3) continue;
            const size_t begin = name.rfind('.', end - 1);
            if (begin == std::string::npos || begin < 2) continue;
            const std::string random = name.substr(begin + 1, end - begin - 1);
            if (random.size() < 10 || random.find_first_not_of("0123456789abcdef") != std::string::npos) continue;
            if (!ours(name.substr(1, begin - 1) + name.substr(end))) continue;
            const int file = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
            if (file < 0) continue;
            if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
            ::close(file);
        }
    }
}

RunLock::RunLock(const std::string& path)
{
    const fs::path target = path;
    name_ = (target.parent_path() / ("." + target.filename().string() + ".lock")).string();
    for (;;) {
        descriptor_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (descriptor_ < 0) throw IoError(system_message(path, "cannot write", errno));
        if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
            const int code = errno;
            char owner[200] = {};
            const bool known = code == EWOULDBLOCK && ::pread(descriptor_, owner, sizeof owner - 1, 0) > 0;
            ::close(descriptor_);
            descriptor_ = -1;
            if (code != EWOULDBLOCK) return;  // no locks here
            throw IoError(printable(path, 4096) + ": another run" + (known ? " (" + printable(owner) + ")" : "") +
                          " writes here: expected one run at a time; wait for its end, or choose another name");
        }
        // Between open() and flock() the last owner may have removed the file, and another run made a new one.
        struct stat mine = {}, present = {};
        if (::fstat(descriptor_, &mine) == 0 && ::stat(name_.c_str(), &present) == 0 && mine.st_ino == present.st_ino)
            break;
        ::close(descriptor_);
    }
    slot_ = remember(name_);
    char host[100] = {};
    ::gethostname(host, sizeof host - 1);
    const std::string owner = "process " + std::to_string(::getpid()) + " on " + host;
    if (::ftruncate(descriptor_, 0) == 0) (void)!::pwrite(descriptor_, owner.data(), owner.size(), 0);
}

RunLock::~RunLock()
{
    if (descriptor_ < 0) return;
    ::unlink(name_.c_str());
    if (slot_ >= 0) slots[slot_].state = Slot::Free;
    ::close(descriptor_);
}

}  // namespace vdbcloud
