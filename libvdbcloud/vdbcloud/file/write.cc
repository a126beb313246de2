#include "vdbcloud/core/archive_layout.h"
#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/half_range.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/descriptor_stream.h"
#include "vdbcloud/file/file_digest.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/math/Half.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <iostream>
#include <ostream>
#include <sstream>

namespace vdbcloud {

namespace {

/// Calls Archive::write on our own stream, because io::File does not check for errors of its stream or of closing.
class Archive : public openvdb::io::Archive {
public:
    void put(std::ostream& stream, const openvdb::GridCPtrVec& grids, const MetaMap& metadata, bool seekable) const
    {
        openvdb::io::Archive::write(stream, grids, seekable, metadata);
    }
};

Archive archive_for(Compression compression)
{
    using namespace openvdb::io;
    Archive archive;
    uint32_t flags = COMPRESS_ACTIVE_MASK;
    if (compression == Compression::Blosc && Archive::hasBloscCompression())
        flags |= COMPRESS_BLOSC;
    else if (compression != Compression::None)
        flags |= COMPRESS_ZIP;
    archive.setCompression(flags);
    return archive;
}

[[noreturn]] void refuse_half(const GridBase& grid, double value, const std::string& where)
{
    std::ostringstream text;
    text << "grid '" << printable(grid.getName()) << "': value " << value << " " << where
         << ": expected at most 65504 to store it as half";
    throw InputError(text.str());
}

/// Throws InputError if a finite value is infinite as half.
void check_half(const GridBase& base)
{
    const auto check = [&](double value, const auto& where) {
        if (std::isfinite(value) && std::abs(value) > double(largest_half)) refuse_half(base, value, where());
    };
    const auto at = [](const openvdb::Coord& ijk) {
        std::ostringstream text;
        text << "at " << ijk;
        return text.str();
    };
    const auto background = [] { return std::string("as background"); };
    if (const auto* grid = dynamic_cast<const FloatGrid*>(&base)) {
        check(grid->background(), background);
        for (auto it = grid->cbeginValueAll(); it; ++it) check(*it, [&] { return at(it.getCoord()); });
    } else if (const auto* colours = dynamic_cast<const Vec3SGrid*>(&base)) {
        for (int c = 0; c < 3; ++c) check(colours->background()[c], background);
        for (auto it = colours->cbeginValueAll(); it; ++it)
            for (int c = 0; c < 3; ++c) check((*it)[c], [&] { return at(it.getCoord()); });
    }
}

template<typename GridT, typename Add>
HalfRange half_range(const GridT& grid, const Add& add)
{
    HalfRange range;
    for (auto it = grid.cbeginValueOn(); it; ++it) add(range, *it);
    return range;
}

/// True if halves would round the active values of a grid away.
bool too_faint_for_half(const GridBase& base)
{
    if (const auto* grid = dynamic_cast<const FloatGrid*>(&base))
        return half_range(*grid, [](HalfRange& range, float x) { range.add(x); }).faint();
    if (const auto* grid = dynamic_cast<const Vec3SGrid*>(&base))
        return half_range(*grid,
                          [](HalfRange& range, const Vec3f& x) {
                              for (int c = 0; c < 3; ++c) range.add(x[c]);
                          })
            .faint();
    return false;
}

float rounded(float x) { return float(openvdb::math::half(x)); }
Vec3f rounded(const Vec3f& x) { return {rounded(x[0]), rounded(x[1]), rounded(x[2])}; }

/// The digest of a grid after storing as half and reading back.
template<typename GridT>
std::string half_digest(const GridT& grid)
{
    const auto half = grid.deepCopy();
    half->tree().root().setBackground(rounded(grid.background()), /*updateChildNodes=*/true);
    for (auto it = half->beginValueOn(); it; ++it) it.setValue(rounded(*it));
    return grid_digest(*half);
}

/// Updates the fingerprint of `source` in the metadata of grids that were computed from it. Storing the source as half
/// changes its digest; without the update the next stage would take those grids for results of another source.
template<typename GridT>
void follow_rounding(const GridT& source, const std::vector<GridBasePtr>& grids)
{
    std::string before, after;
    for (const auto& grid : grids)
        for (const char* key : {schema::density_digest, schema::colour_digest, schema::emission_digest}) {
            const auto meta = grid->getMetadata<openvdb::StringMetadata>(key);
            if (!meta) continue;
            if (before.empty()) before = grid_digest(source);
            if (meta->value() != before) continue;
            if (after.empty()) after = half_digest(source);
            set_text(*grid, key, after);
        }
}

/// Removes what OpenVDB's writer replaces by values of its own where a file brought it with another type: the writer
/// would throw.
void remove_odd_statistics(GridBase& grid)
{
    const std::pair<const char*, const char*> written[] = {{GridBase::META_FILE_COMPRESSION, "string"},
                                                           {GridBase::META_FILE_BBOX_MIN, "vec3i"},
                                                           {GridBase::META_FILE_BBOX_MAX, "vec3i"},
                                                           {GridBase::META_FILE_MEM_BYTES, "int64"},
                                                           {GridBase::META_FILE_VOXEL_COUNT, "int64"}};
    for (const auto& [key, type] : written)
        if (grid[key] && grid[key]->typeName() != type) grid.removeMeta(key);
}

/// Shallow copies of the grids, with the metadata for the file.
std::vector<GridBasePtr> prepared(const GridFile& file, const WriteOptions& options)
{
    std::vector<GridBasePtr> grids;
    for (const auto& original : file.grids) {
        if (!original) continue;
        const auto grid = original->copyGrid();
        grid->setIsInWorldSpace(true);  // written as is_local_space = false
        grid->removeMeta(GridBase::META_FILE_DELAYED_LOAD);
        remove_odd_statistics(*grid);
        if (const schema::GridKind* kind = schema::kind_of(grid->getName())) {
            if (options.half && kind->half) grid->setSaveFloatAsHalf(true);
            if (kind->result) grid->setSaveFloatAsHalf(false);
        }
        if (grid->saveFloatAsHalf() && too_faint_for_half(*grid)) {
            warn(options.warn, "grid '" + printable(grid->getName()) +
                                   "': more than an eighth of its values are below 6.1e-5 and would be rounded away as "
                                   "half: stored as float");
            grid->setSaveFloatAsHalf(false);
        }
        if (grid->saveFloatAsHalf()) check_half(*grid);
        grids.push_back(grid);
    }
    for (const auto& grid : grids) {
        if (!grid->saveFloatAsHalf() || schema::has_role(grid->getName(), schema::Role::Moment)) continue;
        if (const auto* floats = dynamic_cast<const FloatGrid*>(grid.get())) follow_rounding(*floats, grids);
        if (const auto* vectors = dynamic_cast<const Vec3SGrid*>(grid.get())) follow_rounding(*vectors, grids);
    }
    return grids;
}

/// An identifier computed from the contents, so that equal runs write equal bytes. In a pipe the identifier is sent
/// before the grids are serialised, so the digest is of grids and metadata, not of the bytes.
std::string stream_identifier(const std::vector<GridBasePtr>& grids, const MetaMap& metadata)
{
    Digest digest;
    const auto add = [&](const MetaMap& map) {
        std::ostringstream text;
        map.writeMeta(text);
        digest.add_text(text.str());
    };
    add(metadata);
    for (const auto& grid : grids) {
        add(*grid);
        digest.add_text(grid->type());
        digest.add_value(grid->baseTree().activeVoxelCount());
        if (const auto* floats = dynamic_cast<const FloatGrid*>(grid.get())) digest.add_text(grid_digest(*floats));
        if (const auto* vectors = dynamic_cast<const Vec3SGrid*>(grid.get())) digest.add_text(grid_digest(*vectors));
    }
    return digest.uuid();
}

void put(const std::string& path, int descriptor, bool seekable, const GridFile& file, const WriteOptions& options)
{
    const auto grids = prepared(file, options);
    MetaMap metadata = file.metadata ? *file.metadata : MetaMap();
    set_number(metadata, schema::format, schema::format_version);
    DescriptorSink sink(descriptor, seekable, seekable ? std::string() : stream_identifier(grids, metadata));
    std::ostream stream(&sink);
    stream.exceptions(std::ios_base::badbit | std::ios_base::failbit);
    try {
        archive_for(options.compression).put(stream, {grids.begin(), grids.end()}, metadata, seekable);
        stream.flush();
    } catch (const std::ios_base::failure&) {
        throw IoError(system_message(path, "cannot write", sink.error()));
    } catch (const openvdb::Exception& e) {
        throw IoError(printable(path, 4096) + ": cannot write: " + printable(e.what()));
    }
}

}  // namespace

void write_grid_file(const std::string& path, const GridFile& file, const WriteOptions& options)
{
    openvdb::initialize();
    if (path == "-") {
        std::cout.flush();
        put("standard output", STDOUT_FILENO, /*seekable=*/false, file, options);
        return;
    }
    AtomicFile target(path, options.no_clobber);
    put(path, target.descriptor(), target.seekable(), file, options);
    if (target.seekable()) {
        const std::string identifier =
            file_digest(reader_of(target.descriptor())).uuid();  // so that equal runs write equal bytes
        if (::pwrite(target.descriptor(), identifier.data(), identifier.size(), identifier_begin) != identifier_size)
            throw IoError(system_message(path, "cannot write", errno));
    }
    target.commit();
}

}  // namespace vdbcloud
