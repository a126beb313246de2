#include "vdbcloud/file/descriptor_stream.h"
#include "vdbcloud/core/archive_layout.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace vdbcloud {

namespace {
constexpr size_t buffer_size = 1 << 20;
}

ReadAt reader_of(int descriptor)
{
    return [descriptor](void* to, size_t count, uint64_t offset) {
        size_t done = 0;
        while (done < count) {
            const ssize_t n = ::pread(descriptor, static_cast<char*>(to) + done, count - done, off_t(offset + done));
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) throw std::system_error(errno, std::generic_category());
            if (n == 0) break;
            done += size_t(n);
        }
        return done;
    };
}

DescriptorSource::DescriptorSource(ReadAt read, uint64_t size)
    : read_(std::move(read)), size_(size), buffer_(buffer_size)
{
}

DescriptorSource::int_type DescriptorSource::underflow()
{
    const size_t n = read_(buffer_.data(), buffer_.size(), end_);
    end_ += n;
    setg(buffer_.data(), buffer_.data(), buffer_.data() + n);
    return n == 0 ? traits_type::eof() : traits_type::to_int_type(*gptr());
}

std::streamsize DescriptorSource::xsgetn(char* to, std::streamsize count)
{
    std::streamsize done = 0;
    while (done < count) {
        if (gptr() == egptr() && underflow() == traits_type::eof()) break;
        const auto n = std::min<std::streamsize>(count - done, egptr() - gptr());
        std::memcpy(to + done, gptr(), size_t(n));
        setg(eback(), gptr() + n, egptr());
        done += n;
    }
    return done;
}

DescriptorSource::pos_type DescriptorSource::seekoff(off_type off, std::ios_base::seekdir from, std::ios_base::openmode)
{
    const off_type base = from == std::ios_base::beg   ? 0
                          : from == std::ios_base::cur ? off_type(position())
                                                       : off_type(size_);
    const off_type to = base + off;
    if (to < 0 || uint64_t(to) > size_) return pos_type(off_type(-1));
    const off_type begin = off_type(end_) - (egptr() - eback());
    if (to >= begin && to <= off_type(end_)) {
        setg(eback(), eback() + (to - begin), egptr());
    } else {
        end_ = uint64_t(to);
        setg(buffer_.data(), buffer_.data(), buffer_.data());
    }
    return to;
}

DescriptorSource::pos_type DescriptorSource::seekpos(pos_type to, std::ios_base::openmode mode)
{
    return seekoff(off_type(to), std::ios_base::beg, mode);
}

DescriptorSink::DescriptorSink(int descriptor, bool seekable, std::string identifier)
    : descriptor_(descriptor), seekable_(seekable), identifier_(std::move(identifier)), buffer_(buffer_size)
{
    setp(buffer_.data(), buffer_.data() + buffer_.size());
}

bool DescriptorSink::write_out(const char* from, size_t count)
{
    for (size_t done = 0; done < count && !error_;) {
        const ssize_t n = ::write(descriptor_, from + done, count - done);
        if (n >= 0)
            done += size_t(n);
        else if (errno != EINTR)
            error_ = errno;
    }
    start_ += count;
    return !error_;
}

bool DescriptorSink::drain()
{
    const size_t held = size_t(pptr() - pbase());
    if (start_ == 0 && identifier_.size() == identifier_size && held >= identifier_begin + identifier_size)
        std::memcpy(buffer_.data() + identifier_begin, identifier_.data(), identifier_size);
    const bool good = write_out(buffer_.data(), held);
    setp(buffer_.data(), buffer_.data() + buffer_.size());
    return good;
}

DescriptorSink::int_type DescriptorSink::overflow(int_type c)
{
    if (!drain()) return traits_type::eof();
    if (c == traits_type::eof()) return traits_type::not_eof(c);
    *pptr() = traits_type::to_char_type(c);
    pbump(1);
    return c;
}

std::streamsize DescriptorSink::xsputn(const char* from, std::streamsize count)
{
    for (std::streamsize done = 0; done < count;) {
        if (pptr() == epptr() && !drain()) return done;
        const auto n = std::min<std::streamsize>(count - done, epptr() - pptr());
        std::memcpy(pptr(), from + done, size_t(n));
        pbump(int(n));
        done += n;
    }
    return error_ ? 0 : count;
}

int DescriptorSink::sync() { return drain() ? 0 : -1; }

DescriptorSink::pos_type DescriptorSink::seekoff(off_type off, std::ios_base::seekdir from, std::ios_base::openmode)
{
    const off_type here = off_type(start_) + (pptr() - pbase());
    if (from == std::ios_base::cur && off == 0) return error_ ? pos_type(off_type(-1)) : pos_type(here);
    if (!seekable_ || !drain()) return pos_type(off_type(-1));
    const int whence = from == std::ios_base::end ? SEEK_END : SEEK_SET;
    const off_t to = ::lseek(descriptor_, from == std::ios_base::cur ? here + off : off, whence);
    if (to < 0)
        error_ = errno;
    else
        start_ = uint64_t(to);
    return to;
}

DescriptorSink::pos_type DescriptorSink::seekpos(pos_type to, std::ios_base::openmode mode)
{
    return seekoff(off_type(to), std::ios_base::beg, mode);
}

}  // namespace vdbcloud
