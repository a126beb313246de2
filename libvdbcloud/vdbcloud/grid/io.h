#pragma once
// Reading and writing .vdb files and pipes: the only module that touches them.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/core/progress.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

/// Everything one .vdb holds. A stage changes or adds what it makes and passes the rest on, so a pipe carries it all.
struct GridFile {
    std::string path;                    ///< as the user named it, "-" for standard input: for messages
    std::vector<GridBasePtr> grids;      ///< in file order; names need not be unique
    std::shared_ptr<MetaMap> metadata;   ///< of the file; never null
};

struct ReadOptions {
    bool trust = false;                     ///< skip the guard process, for pipelines whose files are their own
    uint64_t max_bytes = uint64_t(16) << 30;  ///< of the file, or of what is taken from standard input
    double guard_cpu_seconds = 0;           ///< 0: by size
    Warn warn;                              ///< told of bytes behind the last grid, which are passed over
};

struct ReadCost {
    uint64_t bytes = 0;
    double guard_seconds = 0;  ///< what reading it a first time in a guarded process cost [s]
    double read_seconds = 0;
    std::string digest;        ///< of the contents without the archive's random identifier, in hex
};

/// Reads a whole .vdb from `path`, or from standard input for "-".
///
/// A damaged file can make OpenVDB's reader corrupt memory, allocate without end or never return, so the file is
/// first read by a forked process with limits on memory and processor time, and only then by this one. Call it
/// before other threads of the program hold locks (fork). Standard input is spooled to an unlinked temporary file.
///
/// Then meaning is checked for every grid of a type we can use: finite invertible transform, voxel edges within
/// 1e-6..1e6 world units, coordinates below 2^30, at most 2^31 active voxels (tiles counted), a registered value type.
///
/// Throws IoError (path first, one sentence; text from the file cut and cleaned).
GridFile read_grid_file(const std::string& path, const ReadOptions& = {}, ReadCost* = nullptr);

enum class Compression { Blosc, Zip, None };

struct WriteOptions {
    Compression compression = Compression::Blosc;
    bool half = false;       ///< density, Cd and moments (scatter_schema.h) as 16-bit floats; an InputError if a value is above 65504
    bool no_clobber = false;  ///< refuse to replace a file that is there
};

/// Writes all grids. To a file: to a temporary beside it, checked, synchronised, then renamed, so that the path never
/// holds half a file. "-" writes a stream to standard output. Names are made unique and plain for viewers only
/// where this program made the grid; what was passed on keeps its name. is_local_space is written false.
///
/// Throws IoError naming the path (full disk, missing folder, closed pipe).
void write_grid_file(const std::string& path, const GridFile&, const WriteOptions& = {});

/// The grid called `name`, or `name[k]` for the k-th (from 0) of that name; null if there is none.
GridBasePtr find_grid(const GridFile&, const std::string& name);

/// The density of a file as floats. `asked` is the user's choice (NAME or NAME[k]), or empty: then the first alias
/// that is there, else the only fog volume (float, class fog or unknown). Where several grids bear the name that
/// fits and the user did not choose, an error that lists NAME[0], NAME[1], ... A level set or points are refused with a
/// sentence. Double, and half, come as float; a grid of another scalar type is refused.
/// Negative values become 0 with one warning that counts them; a value that is not finite is an InputError with its
/// coordinate. Active tiles stay tiles. The grid that is returned is a copy only if something had to change; the
/// file's entry is then replaced by it.
FloatGridPtr density_of(GridFile&, const std::string& asked = {}, const Warn& = {});

/// Finds a grid of another role by its aliases (schema::aliases); null if absent. `asked` as above.
GridBasePtr grid_of(const GridFile&, const std::string& role, const std::string& asked = {});

/// Replaces the grid of the same name, or adds it at the end.
void put_grid(GridFile&, const GridBasePtr&);

/// Removes every grid whose name passes the test.
void remove_grids(GridFile&, const std::function<bool(const std::string&)>&);

/// A fingerprint of a grid's transform, active topology and values, equal for equal grids on any machine, in hex.
std::string grid_digest(const FloatGrid&);

/// Metadata, typed. get_* return `otherwise` where the key is absent; a value of another type is an InputError.
double get_number(const MetaMap&, const std::string& key, double otherwise);
Vec3d get_vector(const MetaMap&, const std::string& key, const Vec3d& otherwise);
std::string get_text(const MetaMap&, const std::string& key, const std::string& otherwise);
bool has_meta(const MetaMap&, const std::string& key);
void set_number(MetaMap&, const std::string& key, double);
void set_vector(MetaMap&, const std::string& key, const Vec3d&);
void set_text(MetaMap&, const std::string& key, const std::string&);

}  // namespace vdbcloud
