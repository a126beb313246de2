#pragma once
// Reading and writing .vdb files and pipes: the only module that touches them.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/grid_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

struct ReadOptions {
    bool trust = false;                       ///< skip the guard process, for pipelines whose files are their own
    uint64_t max_bytes = uint64_t(16) << 30;  ///< of the file, or of what is taken from standard input
    double guard_cpu_seconds = 0;             ///< 0: by size
    Warn warn;                                ///< told of bytes behind the last grid, which are passed over
};

struct ReadCost {
    uint64_t bytes = 0;
    double guard_seconds = 0;  ///< what reading it a first time in a guarded process cost [s]
    double read_seconds = 0;
    std::string digest;  ///< of the contents without the archive's random identifier, in hex
};

/// Reads a whole .vdb from `path`, or from standard input for "-".
///
/// A damaged file can make OpenVDB's reader corrupt memory, allocate without end or never return, so the file
/// is first read by a forked process with limits on memory and processor time, and only then by this one.
/// Call it before other threads of the program hold locks (fork). Standard input is spooled to an unlinked
/// temporary file.
///
/// Then meaning is checked for every grid of a type we can use: finite invertible transform, voxel edges
/// within 1e-6..1e6 world units, coordinates below 2^30, at most 2^31 active voxels (tiles counted), a
/// registered value type.
///
/// Throws IoError (path first, one sentence; text from the file cut and cleaned).
GridFile read_grid_file(const std::string& path, const ReadOptions& = {}, ReadCost* = nullptr);

enum class Compression { Blosc, Zip, None };

struct WriteOptions {
    Compression compression = Compression::Blosc;
    bool half = false;        ///< the kinds that grid/registry.h allows (density, Cd, moments) as 16-bit floats; an
                              ///< InputError if a value is above 65504
    bool no_clobber = false;  ///< refuse to replace a file that is there
};

/// Writes all grids. To a file: to a temporary beside it, checked, synchronised, then renamed, so that the
/// path never holds half a file. "-" writes a stream to standard output. Names are made unique and plain for
/// viewers only where this program made the grid; what was passed on keeps its name. is_local_space is
/// written false. The file's metadata gains vdbcloud:format, the version of docs/format.md.
///
/// Throws IoError naming the path (full disk, missing folder, closed pipe).
void write_grid_file(const std::string& path, const GridFile&, const WriteOptions& = {});

}  // namespace vdbcloud
