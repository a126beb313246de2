#include "vdbcloud/exchange/guarded_bytes.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/guard.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace vdbcloud {

namespace {

constexpr uint64_t most_at_once = 1 << 30;  // bytes of one call of the system

/// Size of a regular file [bytes]. Opens the file, so that a missing permission is said here.
uint64_t size_of(const std::string& path)
{
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat status = {};
    const bool known = descriptor >= 0 && ::fstat(descriptor, &status) == 0;
    const int code = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (!known) throw IoError(system_message(path, "cannot read", code));
    if (!S_ISREG(status.st_mode))
        throw IoError(printable(path, 4096) + ": not a file: this format needs a regular file");
    return uint64_t(status.st_size);
}

}  // namespace

ByteChannel::ByteChannel()
{
    descriptor_ = ::memfd_create("vdbcloud", MFD_CLOEXEC);
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "memfd_create");
}

ByteChannel::~ByteChannel() { ::close(descriptor_); }

void ByteChannel::put(const std::vector<std::string>& texts)
{
    put_size(texts.size());
    for (const std::string& text : texts) put(text);
}

std::string ByteChannel::get_text()
{
    const std::vector<char> text = get<char>();
    return {text.begin(), text.end()};
}

std::vector<std::string> ByteChannel::get_texts()
{
    std::vector<std::string> texts(get_size(sizeof(uint64_t)));
    for (std::string& text : texts) text = get_text();
    return texts;
}

void ByteChannel::put_size(uint64_t count) { write(&count, sizeof count); }

uint64_t ByteChannel::get_size(uint64_t bytes_each)
{
    uint64_t count = 0;
    read(&count, sizeof count);
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0 || count > (uint64_t(status.st_size) - at_) / bytes_each)
        throw InputError("the reader of this format ended too early");
    return count;
}

void ByteChannel::write(const void* bytes, uint64_t count)
{
    const char* from = static_cast<const char*>(bytes);
    while (count > 0) {
        const ssize_t done = ::write(descriptor_, from, size_t(std::min(count, most_at_once)));
        if (done < 0 && errno != EINTR) throw std::bad_alloc();  // the system has no memory for the channel
        if (done < 0) continue;
        from += done;
        count -= uint64_t(done);
    }
}

void ByteChannel::read(void* bytes, uint64_t count)
{
    char* to = static_cast<char*>(bytes);
    while (count > 0) {
        const ssize_t done = ::pread(descriptor_, to, size_t(std::min(count, most_at_once)), off_t(at_));
        if (done == 0 || (done < 0 && errno != EINTR)) throw InputError("the reader of this format ended too early");
        if (done < 0) continue;
        to += done;
        at_ += uint64_t(done);
        count -= uint64_t(done);
    }
}

void read_guarded(const std::string& path, const std::function<void()>& work)
{
    const uint64_t bytes = size_of(path);
    GuardLimits limits;
    limits.memory_bytes = (uint64_t(1) << 30) + 64 * bytes;
    limits.cpu_seconds = 10 + double(bytes) / 5e6;
    const std::string said = run_guarded(work, limits);
    if (said.empty()) return;
    const std::string file = printable(path, 4096) + ": ";
    throw InputError(said.rfind(file, 0) == 0 ? printable(said, 6000) : file + printable(said, 1000));
}

}  // namespace vdbcloud
