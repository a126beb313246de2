#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/descriptor_stream.h"
#include "vdbcloud/file/file_digest.h"
#include "vdbcloud/file/guard.h"
#include "vdbcloud/file/header.h"
#include "vdbcloud/file/input_bytes.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <openvdb/io/Stream.h>

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <istream>
#include <sstream>
#include <system_error>

namespace vdbcloud {

namespace {

struct Contents {
    openvdb::GridPtrVecPtr grids;
    MetaMap::Ptr metadata;
    uint64_t end = 0;  // file position after the last grid
};

void check_transform(const Transform& transform, const std::string& what)
{
    if (!transform.isLinear()) return;  // stages that need an affine transform check for it
    openvdb::Mat4d matrix;
    try {
        matrix = transform.baseMap()->getAffineMap()->getMat4();
    } catch (const openvdb::ArithmeticError&) {
        throw IoError(what + ": its transform is not finite or not invertible");
    }
    for (int k = 0; k < 16; ++k)
        if (!std::isfinite(matrix.asPointer()[k])) throw IoError(what + ": its transform is not finite");
    const Vec3d edges = transform.voxelSize();
    for (int axis = 0; axis < 3; ++axis) {
        if (edges[axis] >= 1e-6 && edges[axis] <= 1e6) continue;
        std::ostringstream text;
        text << what << ": voxel edge " << edges[axis] << ": expected 1e-6 to 1e6 world units";
        throw IoError(text.str());
    }
    if (!(std::abs(matrix.det()) > 1e-9 * edges[0] * edges[1] * edges[2]))
        throw IoError(what + ": its transform is flat (not invertible)");
}

std::string called(const std::string& path, const GridBase& grid)
{
    return printable(path, 4096) + ": grid '" + printable(grid.getName()) + "'";
}

/// Checks what all stages need of a grid: transform and coordinates.
void check_grid(const GridBase& grid, const std::string& path)
{
    const std::string what = called(path, grid);
    check_transform(grid.transform(), what);
    openvdb::CoordBBox box;
    if (!grid.baseTree().evalActiveVoxelBoundingBox(box)) return;
    constexpr int32_t most = 1 << 30;
    for (int axis = 0; axis < 3; ++axis)
        if (box.min()[axis] <= -most || box.max()[axis] >= most) {
            std::ostringstream text;
            text << what << ": active voxels from " << box.min() << " to " << box.max()
                 << ": expected coordinates below 2^30";
            throw IoError(text.str());
        }
}

/// Apart from the other checks, because counting uses threads, which the guard process does not have.
void check_count(const GridBase& grid, const std::string& path)
{
    if (const auto voxels = grid.baseTree().activeVoxelCount(); voxels > uint64_t(1) << 31)
        throw IoError(called(path, grid) + ": " + std::to_string(voxels) + " active voxels: expected at most 2^31");
}

/// Reads the whole file without delayed loading and checks the grids. Catches no exceptions.
Contents load(const std::string& path, const InputBytes& input)
{
    DescriptorSource source(input.reader(), input.size());
    std::istream stream(&source);
    stream.exceptions(std::ios_base::badbit | std::ios_base::failbit);
    openvdb::io::Stream archive(stream, /*delayLoad=*/false);
    Contents contents{archive.getGrids(), archive.getMetadata(), source.position()};
    for (const auto& grid : *contents.grids) check_grid(*grid, path);
    return contents;
}

/// Message for the current exception, thrown by load().
std::string load_failure(const std::string& path, uint64_t size)
{
    const std::string file = printable(path, 4096);
    try {
        throw;
    } catch (const IoError& e) {
        return e.what();
    } catch (const std::bad_alloc&) {
        return file + ": too large: there is not enough memory to read it";
    } catch (const std::ios_base::failure&) {
        return file + ": malformed .vdb: ends too early, at " + std::to_string(size) + " bytes";
    } catch (const std::system_error& e) {
        return system_message(path, "cannot read", e.code().value());
    } catch (const std::exception& e) {
        return file + ": malformed .vdb: " + printable(e.what());
    }
}

/// Reads every value, as a stage does. The sum keeps the compiler from removing the reads.
template<typename GridT>
void walk(const GridBase& base)
{
    const auto* grid = dynamic_cast<const GridT*>(&base);
    if (!grid) return;
    uint64_t sum = 0;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf)
        for (auto value = leaf->cbeginValueAll(); value; ++value) sum += *value == grid->background();
    volatile uint64_t kept = sum;
    (void)kept;
}

void try_in_guard(const std::string& path, const InputBytes& input, const ReadOptions& options)
{
    GuardLimits limits;
    limits.memory_bytes = (uint64_t(1) << 30) + 256 * input.size();
    limits.cpu_seconds = options.guard_cpu_seconds > 0 ? options.guard_cpu_seconds : 5 + double(input.size()) / 10e6;
    const std::string said = run_guarded(
        [&] {
            const Contents contents = load(path, input);
            for (const auto& grid : *contents.grids) {
                walk<FloatGrid>(*grid);
                walk<Vec3SGrid>(*grid);
            }
            ::_exit(0);  // skips destructors: they need threads, which a forked process lacks
        },
        limits, [&] { return load_failure(path, input.size()); });
    if (said.empty()) return;
    const std::string prefix = printable(path, 4096) + ": ";
    throw IoError(said.compare(0, prefix.size(), prefix) == 0 ? printable(said, 6000) : prefix + printable(said, 1000));
}

/// Refuses a file whose metadata vdbcloud:format is newer than this version of vdbcloud reads: by that number, some
/// grid or key has another meaning. A file without the key comes from another program and is read.
void check_format(const std::string& path, const MetaMap& metadata)
{
    const std::string file = printable(path, 4096) + ": ";
    double format = schema::format_version;
    try {
        format = get_number(metadata, schema::format, format);
    } catch (const InputError& e) {
        throw IoError(file + e.what());
    }
    if (format >= 1 && format <= schema::format_version) return;
    std::ostringstream text;
    text << file << "metadata '" << schema::format << "' = " << format << ": expected ";
    if (schema::format_version > 1) text << "1 to ";
    text << schema::format_version;
    if (format > schema::format_version) text << ": a newer vdbcloud wrote this file, update vdbcloud to read it";
    throw IoError(text.str());
}

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

GridFile read_grid_file(const std::string& path, const ReadOptions& options, ReadCost* cost)
{
    openvdb::initialize();
    auto start = std::chrono::steady_clock::now();
    const InputBytes input(path, {options.max_bytes, options.memory_bytes, !options.trust});
    check_header(path, input.reader(), input.size());
    const double copy_seconds = seconds_since(start);

    start = std::chrono::steady_clock::now();
    if (!options.trust) try_in_guard(path, input, options);
    const double guard_seconds = seconds_since(start);

    start = std::chrono::steady_clock::now();
    Contents contents;
    try {
        contents = load(path, input);
    } catch (...) {
        throw IoError(load_failure(path, input.size()));
    }
    for (const auto& grid : *contents.grids) check_count(*grid, path);
    check_format(path, *contents.metadata);
    if (contents.end < input.size())
        warn(options.warn, printable(path, 4096) + ": " + std::to_string(input.size() - contents.end) +
                               " bytes behind the last grid are passed over");
    if (cost)
        *cost = {input.size(), guard_seconds, copy_seconds + seconds_since(start), file_digest(input.reader()).hex()};
    return {path, *contents.grids, contents.metadata};
}

}  // namespace vdbcloud
