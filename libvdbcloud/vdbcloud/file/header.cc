#include "vdbcloud/file/header.h"

#include "vdbcloud/core/archive_layout.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/file/descriptor_stream.h"

#include <openvdb/Grid.h>
#include <openvdb/version.h>

#include <cstring>

namespace vdbcloud {

namespace {

constexpr uint32_t oldest_checked = 220;  // older headers have another layout and are not checked
constexpr int most_grids = 4096;
const std::string half_suffix = "_HalfFloat";

/// Reads values in sequence, never beyond the end of the file.
class Cursor {
public:
    Cursor(const std::string& path, const ReadAt& read, uint64_t size) : path_(path), read_(read), size_(size) {}

    template<typename T>
    T take()
    {
        T x;
        need(sizeof x);
        if (read_(&x, sizeof x, at_) != sizeof x) fail("ends too early");
        at_ += sizeof x;
        return x;
    }

    /// A string; only its first 1000 bytes are kept.
    std::string text()
    {
        const auto length = take<uint32_t>();
        need(length);
        std::string s(std::min<size_t>(length, 1000), '\0');
        if (read_(s.data(), s.size(), at_) != s.size()) fail("ends too early");
        at_ += length;
        return s;
    }

    void skip(uint64_t count)
    {
        need(count);
        at_ += count;
    }

    void go(uint64_t position) { at_ = position; }
    uint64_t at() const { return at_; }
    uint64_t size() const { return size_; }

    [[noreturn]] void fail(const std::string& what) const
    {
        throw IoError(printable(path_, 4096) + ": malformed .vdb: " + what);
    }

private:
    void need(uint64_t count) const
    {
        if (count > size_ - at_) fail("ends too early, at " + std::to_string(size_) + " bytes");
    }

    const std::string& path_;
    const ReadAt& read_;
    uint64_t size_, at_ = 0;
};

void check_metadata(Cursor& file)
{
    const auto count = file.take<uint32_t>();
    for (uint32_t k = 0; k < count; ++k) {  // terminates: each key takes at least 12 bytes of the file
        file.text();                        // name
        file.text();                        // type
        file.skip(file.take<uint32_t>());
    }
}

/// Checks one grid's descriptor and moves to the next descriptor. False if the file does not give the next position.
bool check_descriptor(Cursor& file, bool offsets)
{
    std::string name = file.text(), type = file.text();
    // OpenVDB appends the character 0x1e and a number to equal names.
    name.resize(std::min(name.find('\x1e'), name.size()));
    file.text();  // name of the grid that shares the tree
    const auto begin = file.take<int64_t>(), block = file.take<int64_t>(), end = file.take<int64_t>();

    const size_t plain = type.size() - std::min(type.size(), half_suffix.size());
    if (type.compare(plain, std::string::npos, half_suffix) == 0) type.resize(plain);
    if (!openvdb::GridBase::isRegistered(type))
        file.fail("grid '" + printable(name) + "' has the unknown type '" + printable(type) + "'");
    if (!offsets) return false;

    const auto here = int64_t(file.at()), size = int64_t(file.size());
    if (begin < here || end < begin || block > end) file.fail("grid '" + printable(name) + "' has impossible offsets");
    if (end > size)
        file.fail("ends too early: grid '" + printable(name) + "' reaches to byte " + std::to_string(end) + " of " +
                  std::to_string(size));
    file.go(uint64_t(end));
    return true;
}

}  // namespace

bool has_magic(const void* bytes)
{
    int32_t magic;
    std::memcpy(&magic, bytes, sizeof magic);
    return magic == openvdb::OPENVDB_MAGIC;
}

void check_header(const std::string& path, const ReadAt& read, uint64_t size)
{
    Cursor file(path, read, size);
    if (size < 8)
        throw IoError(printable(path, 4096) + ": expected a .vdb, found only " + std::to_string(size) + " bytes");
    const auto magic = file.take<int64_t>();
    if (!has_magic(&magic)) throw IoError(printable(path, 4096) + ": " + wrong_magic);

    const auto version = file.take<uint32_t>();
    if (version > openvdb::OPENVDB_FILE_VERSION)
        throw IoError(printable(path, 4096) + ": .vdb format " + std::to_string(version) + ": expected " +
                      std::to_string(openvdb::OPENVDB_FILE_VERSION) + " or older (OpenVDB " +
                      openvdb::getLibraryVersionString() + ")");
    if (version < oldest_checked) return;
    file.skip(8);  // version of the library
    const auto offsets = file.take<char>();
    if (offsets != 0 && offsets != 1) file.fail("an impossible flag in its header");
    if (version < 222) file.skip(1);  // compression flag; from 222 on stored for each grid
    file.skip(identifier_size);
    check_metadata(file);

    const auto grids = file.take<int32_t>();
    if (grids < 0 || grids > most_grids)
        file.fail("it claims " + std::to_string(grids) + " grids: expected at most " + std::to_string(most_grids));
    for (int k = 0; k < grids; ++k)
        if (!check_descriptor(file, offsets)) break;
}

}  // namespace vdbcloud
