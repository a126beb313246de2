#pragma once
// Streams on file descriptors. Reading shares no file position with another process; writing keeps the system's error.
// Private to file/.
#include <cstdint>
#include <functional>
#include <streambuf>
#include <string>
#include <vector>

namespace vdbcloud {

/// Reads up to `count` bytes at position `offset`; returns the number of bytes read. Throws std::system_error.
using ReadAt = std::function<size_t(void* to, size_t count, uint64_t offset)>;

/// Reads by position, so that a forked process can read the same bytes.
class DescriptorSource : public std::streambuf {
public:
    DescriptorSource(ReadAt, uint64_t size);
    uint64_t position() const { return end_ - uint64_t(egptr() - gptr()); }

protected:
    int_type underflow() override;
    std::streamsize xsgetn(char* to, std::streamsize count) override;
    pos_type seekoff(off_type, std::ios_base::seekdir, std::ios_base::openmode) override;
    pos_type seekpos(pos_type, std::ios_base::openmode) override;

private:
    ReadAt read_;
    uint64_t size_, end_ = 0;  // end_: file position of egptr()
    std::vector<char> buffer_;
};

/// Writes to a descriptor. After a failure every later write fails too, and error() is the errno of the first failure.
class DescriptorSink : public std::streambuf {
public:
    /// `seekable`: the descriptor supports positions. `identifier`, if not empty, replaces the 36 characters of the
    /// archive's identifier as they are written.
    DescriptorSink(int descriptor, bool seekable, std::string identifier = {});
    int error() const { return error_; }

protected:
    int_type overflow(int_type) override;
    std::streamsize xsputn(const char* from, std::streamsize count) override;
    int sync() override;
    pos_type seekoff(off_type, std::ios_base::seekdir, std::ios_base::openmode) override;
    pos_type seekpos(pos_type, std::ios_base::openmode) override;

private:
    bool drain();
    bool write_out(const char* from, size_t count);

    int descriptor_, error_ = 0;
    bool seekable_;
    uint64_t start_ = 0;  // file position of pbase()
    std::string identifier_;
    std::vector<char> buffer_;
};

/// Reads the file of a descriptor, which stays open and where it is.
ReadAt reader_of(int descriptor);

}  // namespace vdbcloud
