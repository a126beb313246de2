#pragma once
// The bytes of an input, read once. Private to file/.
#include "vdbcloud/file/descriptor_stream.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

/// A private copy of a file or of standard input ("-"): what the guard process proves, this process reads, whatever
/// other programs do to the file meanwhile. Copies above a limit are in an unlinked temporary file.
class InputBytes {
public:
    struct Limits {
        uint64_t most;       ///< largest accepted size [bytes]
        uint64_t in_memory;  ///< largest size that is kept in memory [bytes]
        bool copy = true;    ///< false: a regular file above in_memory is read in place
    };

    /// Throws IoError, beginning with the path: the file cannot be read, is too large, is no .vdb by its first bytes,
    /// or changes while it is copied; or there is no room for the copy.
    InputBytes(const std::string& path, const Limits&);
    ~InputBytes();
    InputBytes(const InputBytes&) = delete;
    InputBytes& operator=(const InputBytes&) = delete;

    uint64_t size() const { return size_; }
    /// Threads may call the reader at once. It is valid as long as this object.
    ReadAt reader() const;

private:
    void open();
    void copy(const Limits&);
    void copy_bytes(const Limits&, bool regular, uint64_t start);
    void keep(const char* bytes, size_t count, uint64_t in_memory);
    void spill();
    [[noreturn]] void fail(const std::string& what) const;

    std::string path_;
    int source_ = -1;  // the input itself
    int kept_ = -1;    // the copy, where it is not in memory_
    std::vector<char> memory_;
    uint64_t size_ = 0;
};

}  // namespace vdbcloud
