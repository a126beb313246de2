#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/descriptor_stream.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/io.h"
#include "vdbcloud/grid/schema.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <iostream>
#include <ostream>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr double half_max = 65504;  // the largest finite 16-bit float

/// Archive::write on a stream of our own: io::File checks neither its stream nor what closing it says.
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
    if (compression == Compression::Blosc && Archive::hasBloscCompression()) flags |= COMPRESS_BLOSC;
    else if (compression != Compression::None) flags |= COMPRESS_ZIP;
    archive.setCompression(flags);
    return archive;
}

bool is_one_of(const std::string& name, const std::vector<std::string>& names)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

[[noreturn]] void refuse_half(const GridBase& grid, double value, const openvdb::Coord& at)
{
    std::ostringstream text;
    text << "grid '" << printable(grid.getName()) << "': value " << value << " at " << at
         << ": expected at most 65504 to store it as half";
    throw InputError(text.str());
}

void check_half(const GridBase& base)
{
    if (const auto* grid = dynamic_cast<const FloatGrid*>(&base)) {
        for (auto it = grid->cbeginValueAll(); it; ++it)
            if (!(std::abs(*it) <= half_max)) refuse_half(base, *it, it.getCoord());
    } else if (const auto* colours = dynamic_cast<const Vec3SGrid*>(&base)) {
        for (auto it = colours->cbeginValueAll(); it; ++it)
            for (int c = 0; c < 3; ++c)
                if (!(std::abs((*it)[c]) <= half_max)) refuse_half(base, (*it)[c], it.getCoord());
    }
}

/// Shallow copies of the grids with the metadata they are to have in the file.
std::vector<GridBasePtr> prepared(const GridFile& file, const WriteOptions& options)
{
    const auto densities = schema::aliases(schema::density), colours = schema::aliases(schema::colour);
    std::vector<GridBasePtr> grids;
    for (const auto& original : file.grids) {
        if (!original) continue;
        const auto grid = original->copyGrid();
        grid->setIsInWorldSpace(true);  // written as is_local_space = false
        grid->removeMeta(GridBase::META_FILE_DELAYED_LOAD);
        if (options.half && (is_one_of(grid->getName(), densities) || is_one_of(grid->getName(), colours)))
            grid->setSaveFloatAsHalf(true);
        if (grid->saveFloatAsHalf()) check_half(*grid);
        grids.push_back(grid);
    }
    return grids;
}

/// An identifier from the contents, so that equal runs write equal bytes: of what goes through a pipe, whose first
/// bytes leave before the last are known, by the grids themselves.
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
    }
    return digest.uuid();
}

void put(const std::string& path, int descriptor, bool seekable, const GridFile& file, const WriteOptions& options)
{
    const auto grids = prepared(file, options);
    const MetaMap none, &metadata = file.metadata ? *file.metadata : none;
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
        put(path, STDOUT_FILENO, /*seekable=*/false, file, options);
        return;
    }
    AtomicFile target(path, options.no_clobber);
    put(path, target.descriptor(), target.seekable(), file, options);
    if (target.seekable()) {
        const std::string identifier = file_digest(target.descriptor()).uuid();  // so that equal runs write equal bytes
        if (::pwrite(target.descriptor(), identifier.data(), identifier.size(), identifier_begin) != identifier_size)
            throw IoError(system_message(path, "cannot write", errno));
    }
    target.commit();
}

}  // namespace vdbcloud
