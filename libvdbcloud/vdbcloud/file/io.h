#pragma once
// Reading and writing .vdb files and pipes. No other module of the library opens .vdb files.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

struct ReadOptions {
    bool trust = false;  ///< true: no guard process; for pipelines that read only their own files; inputs above
                         ///< memory_bytes are then read in place
    uint64_t max_bytes = uint64_t(16) << 30;      ///< largest accepted size of the file or of standard input [bytes]
    uint64_t memory_bytes = uint64_t(256) << 20;  ///< larger inputs are copied to an unlinked temporary file in TMPDIR
    double guard_cpu_seconds = 0;                 ///< processor time limit of the guard process [s]; 0: by file size
    Warn warn;                                    ///< receives one warning if bytes after the last grid are ignored
};

struct ReadCost {
    uint64_t bytes = 0;
    double guard_seconds = 0;  ///< time for the first read, in the guard process [s]
    double read_seconds = 0;   ///< time for the copy and for the second read, in this process [s]
    std::string digest;        ///< file_digest() in hex: contents without the archive's random identifier
};

/// Reads a whole .vdb from `path`, or from standard input for "-".
///
/// A damaged file can make OpenVDB's reader corrupt memory, allocate without end or never return. So a forked process
/// (the guard process) with limits on memory and processor time reads the bytes first; then this process reads them.
/// Both read one private copy of the file, so another program may write to it meanwhile: a file that changes while it
/// is copied is refused. Because of the fork, call this function while no other thread of the program holds a lock.
///
/// Each grid must have a registered value type, a finite invertible transform, and voxel edges within 1e-6..1e6 world
/// units. Active voxels must have coordinates below 2^30; at most 2^31 may be active (a tile counts as its voxels).
/// File metadata vdbcloud:format, if there is one, must not be newer than schema::format_version.
///
/// Throws IoError: one sentence that begins with the path; text from the file is shortened and made printable.
GridFile read_grid_file(const std::string& path, const ReadOptions& = {}, ReadCost* = nullptr);

enum class Compression { Blosc, Zip, None };

struct WriteOptions {
    Compression compression = Compression::Blosc;
    /// Stores the kinds that grid/registry.h allows (density, Cd, moments) as 16-bit floats. write_grid_file() then
    /// throws InputError if the magnitude of a finite value is above 65504. A grid of which halves would round more
    /// than an eighth of the values away (HalfRange::faint) is stored as floats.
    bool half = false;
    bool no_clobber = false;  ///< true: refuse to replace an existing file
    Warn warn;                ///< receives a warning for each grid that is not stored as half
};

/// Writes all grids. "-" writes a stream to standard output.
///
/// A file is written to a temporary in the same folder, checked, synchronised, then renamed. So the path never has an
/// incomplete file. Grids keep their names, which need not be unique. is_local_space is written false. File metadata
/// vdbcloud:format is set to the version of docs/format.md.
///
/// Throws IoError naming the path (full disk, missing folder, closed pipe).
void write_grid_file(const std::string& path, const GridFile&, const WriteOptions& = {});

}  // namespace vdbcloud
