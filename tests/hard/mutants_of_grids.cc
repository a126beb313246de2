#include "hard/body.h"
#include "hard/mutants.h"

#include "support/grids.h"

#include "vdbcloud/grid/registry.h"

#include <openvdb/io/Stream.h>
#include <zlib.h>

#include <limits>
#include <sstream>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

using openvdb::Coord;

constexpr double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

double bad_number(Dice& dice)
{
    return dice.one_of({nan, infinity, -infinity, 1e308, -1e308, 1e300, 1e39, -1.0, 0.0, 1e-320, 1e9, -1e9,
                        2147483648.0, 0.9999999999, 1.0, 4294967296.5});
}

std::string bad_text(Dice& dice)
{
    switch (dice.below(9)) {
    case 0: return "";
    case 1: return std::string(size_t(1) << 20, 'x');
    case 2: return "\x1b[31mred\x1b[0m\a\n\r\t\x7f";
    case 3: return std::string("a\0b", 3);
    case 4: return "nan inf -inf 1e999";
    case 5: return "density[99999999999999999999]";
    case 6: return std::string(400, '9');
    case 7: return "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25";
    default: return "\xff\xfe\xc3\x28 %s%n ../../etc";
    }
}

openvdb::Metadata::Ptr bad_value(Dice& dice, std::string& what)
{
    const double x = bad_number(dice);
    std::ostringstream text;
    text << x;
    what += text.str();
    switch (dice.below(9)) {
    case 0: return std::make_shared<openvdb::DoubleMetadata>(x);
    case 1: return std::make_shared<openvdb::FloatMetadata>(float(x));
    case 2: return std::make_shared<openvdb::Vec3DMetadata>(Vec3d(x, dice.chance(0.5) ? x : 0.5, 1));
    case 3: return std::make_shared<openvdb::Vec3SMetadata>(Vec3f(float(x)));
    case 4: return std::make_shared<openvdb::Int32Metadata>(dice.one_of({0, -1, 2147483647, -2147483647}));
    case 5: return std::make_shared<openvdb::Int64Metadata>(dice.one_of<int64_t>({0, -1, int64_t(1) << 62}));
    case 6: return std::make_shared<openvdb::BoolMetadata>(dice.chance(0.5));
    case 7: return std::make_shared<openvdb::Mat4DMetadata>(openvdb::Mat4d::identity() * x);
    default: what += " as text"; return std::make_shared<openvdb::StringMetadata>(bad_text(dice));
    }
}

/// A map of the file, with its keys.
struct Place {
    MetaMap* map;
    std::string name;
};

void change_key(const GridFile& file, Dice& dice, std::string& what)
{
    std::vector<Place> places{{file.metadata.get(), "file"}};
    for (const GridBasePtr& grid : file.grids) places.push_back({grid.get(), grid->getName()});
    const Place& place = places[dice.below(places.size())];
    std::vector<std::string> keys;
    for (auto entry = place.map->beginMeta(); entry != place.map->endMeta(); ++entry)
        if (entry->first.rfind("file_", 0) != 0) keys.push_back(entry->first);  // those are written anew
    const auto& ours = schema::meta_keys();
    std::string key = ours[dice.below(ours.size())].key;
    if (!keys.empty() && dice.chance(0.6)) key = keys[dice.below(keys.size())];
    what += "key " + key + " of " + place.name + " = ";
    place.map->removeMeta(key);
    if (dice.chance(0.2))
        what += "missing";
    else
        place.map->insertMeta(key, *bad_value(dice, what));
}

void change_name(const GridFile& file, Dice& dice, std::string& what)
{
    const auto& grid = file.grids[dice.below(file.grids.size())];
    what += "another name of " + grid->getName();
    const auto& kinds = schema::grid_kinds();
    switch (dice.below(4)) {
    case 0: grid->setName(bad_text(dice)); break;
    case 1: grid->setName(file.grids[dice.below(file.grids.size())]->getName()); break;
    case 2: grid->setName(kinds[dice.below(kinds.size())].name); break;
    default: grid->setName(grid->getName() + dice.one_of({",", "[0]", "\n", "_", "9", "99999999999", " ", "\x1e"}));
    }
}

/// Another value type under the same name.
void change_type(GridFile& file, Dice& dice, std::string& what)
{
    GridBasePtr& grid = file.grids[dice.below(file.grids.size())];
    const std::string type =
        dice.one_of({"Tree_bool_5_4_3", "Tree_double_5_4_3", "Tree_int32_5_4_3", "Tree_int64_5_4_3", "Tree_vec3d_5_4_3",
                     "Tree_vec3i_5_4_3", "Tree_vec3s_5_4_3", "Tree_float_5_4_3", "Tree_mask_5_4_3"});
    what += grid->getName() + " as " + type;
    const auto other = openvdb::GridBase::createGrid(type);
    other->insertMeta(*grid);
    other->setTransform(grid->transformPtr());
    if (const auto doubles = openvdb::gridPtrCast<openvdb::DoubleGrid>(other))
        doubles->tree().setValue(Coord(2, 2, 2), bad_number(dice));
    grid = other;
}

openvdb::math::Transform::Ptr bad_transform(Dice& dice)
{
    const double x = bad_number(dice);
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    switch (dice.below(6)) {
    case 0: matrix(int(dice.below(4)), int(dice.below(4))) = x; break;
    case 1: matrix.preScale(Vec3d(1e-7)); break;
    case 2: matrix.postTranslate(Vec3d(x, 0, 0)); break;
    case 3: matrix(0, 1) = matrix(1, 0) = 0.999999999; break;
    case 4: matrix.preScale(Vec3d(1e6, 1e-4, 1)); break;
    default:
        return openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(8)),
                                                                dice.one_of({0.5, 1e-9}), 10, 1);
    }
    return openvdb::math::Transform::createLinearTransform(matrix);
}

void change_transform(const GridFile& file, Dice& dice, std::string& what)
{
    const auto& grid = file.grids[dice.below(file.grids.size())];
    what += "transform of " + grid->getName();
    try {
        grid->setTransform(bad_transform(dice));
        grid->copyGrid();                  // as a writer does
    } catch (const openvdb::Exception&) {  // OpenVDB itself refuses it: a small voxel instead
        grid->setTransform(openvdb::math::Transform::createLinearTransform(1e-4));
    }
}

/// A place far away, or near.
Coord place(Dice& dice)
{
    const int far = dice.one_of({1 << 30, -(1 << 30), 2147483640, -2147483640, 1 << 20, 5000, 3, -1});
    return {far, dice.chance(0.5) ? far : 1, dice.chance(0.5) ? -far / 2 : 2};
}

template<typename Grid, typename Value>
void change_values(Grid& grid, const Value& value, Dice& dice, std::string& what)
{
    switch (dice.below(7)) {
    case 0:
        what += "background";
        grid.tree().root().setBackground(value, dice.chance(0.5));
        break;
    case 1:
        what += "values";
        for (auto at = grid.beginValueOn(); at; ++at)
            if (dice.chance(0.3)) at.setValue(value);
        break;
    case 2:
        what += "inactive values";
        for (auto at = grid.beginValueOff(); at; ++at)
            if (at.isVoxelValue()) at.setValue(value);
        break;
    case 3:
        what += "a voxel far away";
        grid.tree().setValue(place(dice), value);
        break;
    case 4:
        what += "a tile";
        grid.tree().addTile(openvdb::Index(1 + dice.below(3)), place(dice), value, dice.chance(0.7));
        break;
    case 5:
        what += "no voxel";
        grid.tree().clear();
        break;
    default:
        what += "dust";
        for (int k = 0; k < 300; ++k)
            grid.tree().setValue(Coord(int(dice.below(1 << 20)), int(dice.below(1 << 20)), int(dice.below(1 << 20))),
                                 value);
    }
    what += " of " + grid.getName();
}

void change_values(const GridFile& file, Dice& dice, std::string& what)
{
    const auto& grid = file.grids[dice.below(file.grids.size())];
    const double x = bad_number(dice);
    const float value = dice.chance(0.3) ? 1.0f : float(x);
    what += "value " + std::to_string(value) + ": ";
    if (const auto floats = openvdb::gridPtrCast<FloatGrid>(grid))
        change_values(*floats, value, dice, what);
    else if (const auto vectors = openvdb::gridPtrCast<Vec3SGrid>(grid))
        change_values(*vectors, Vec3f(value, 1, value), dice, what);
}

void change_flags(const GridFile& file, Dice& dice, std::string& what)
{
    const auto& grid = file.grids[dice.below(file.grids.size())];
    what += "flags of " + grid->getName();
    grid->setGridClass(dice.one_of({openvdb::GRID_LEVEL_SET, openvdb::GRID_STAGGERED, openvdb::GRID_UNKNOWN}));
    grid->setIsInWorldSpace(dice.chance(0.5));
    grid->setSaveFloatAsHalf(dice.chance(0.5));
    grid->setVectorType(openvdb::VEC_COVARIANT_NORMALIZE);
}

void change_list(GridFile& file, Dice& dice, std::string& what)
{
    const size_t at = dice.below(file.grids.size());
    what += "without or twice " + file.grids[at]->getName();
    if (dice.chance(0.5) && file.grids.size() > 1)
        file.grids.erase(file.grids.begin() + std::ptrdiff_t(at));
    else
        file.grids.push_back(file.grids[at]->copyGrid());
}

std::string as_bytes(const std::vector<GridBasePtr>& grids, const MetaMap& metadata, uint32_t compression)
{
    std::ostringstream out(std::ios::binary);
    openvdb::io::Stream stream(out);
    stream.setCompression(compression);
    stream.write(openvdb::GridCPtrVec(grids.begin(), grids.end()), metadata);
    return out.str();
}

/// A zlib stream that unpacks to 3 GiB of zeros. A block that ends with a full flush depends on nothing before it, so
/// one block of a MiB, repeated, is a valid stream.
const std::string& zip_bomb()
{
    static const std::string bomb = [] {
        std::string zeros(size_t(1) << 20, '\0'), block(size_t(1) << 16, '\0');
        z_stream stream{};
        if (deflateInit(&stream, Z_BEST_COMPRESSION) != Z_OK) throw std::runtime_error("zlib does not start");
        stream.next_in = reinterpret_cast<Bytef*>(zeros.data());
        stream.avail_in = uInt(zeros.size());
        stream.next_out = reinterpret_cast<Bytef*>(block.data());
        stream.avail_out = uInt(block.size());
        const int status = deflate(&stream, Z_FULL_FLUSH);
        block.resize(stream.total_out);
        deflateEnd(&stream);
        if (status != Z_OK || stream.avail_in != 0) throw std::runtime_error("zlib does not pack a MiB of zeros");
        std::string bytes = block;
        for (int k = 1; k < 3 * 1024; ++k) bytes.append(block, 2);  // the header of two bytes comes once
        return bytes;
    }();
    return bomb;
}

}  // namespace

std::string hostile_grids(const std::string& vdb_path, Dice& dice, std::string& what)
{
    GridFile file = read_own(vdb_path);
    const auto compression = dice.one_of<uint32_t>({openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP,
                                                    openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC});
    const std::string healthy = as_bytes(file.grids, *file.metadata, compression);
    try {
        for (size_t more = 1 + dice.below(3); more > 0; --more) {
            what += what.empty() ? "" : "; ";
            switch (dice.below(10)) {
            case 0: change_name(file, dice, what); break;
            case 1: change_type(file, dice, what); break;
            case 2: change_transform(file, dice, what); break;
            case 3: change_flags(file, dice, what); break;
            case 4: change_list(file, dice, what); break;
            case 5:
            case 6: change_values(file, dice, what); break;
            default: change_key(file, dice, what);
            }
        }
        return as_bytes(file.grids, *file.metadata, compression);
    } catch (const openvdb::TypeError&) {  // a name or a class that is a number: OpenVDB itself cannot write it
        return what += ", which cannot be written; damaged instead", damaged(healthy, dice);
    }
}

std::string hostile_compression(std::string bytes, Dice& dice, std::string& what)
{
    // A compressed part begins with its length; then zlib's or Blosc's own header follows.
    std::vector<size_t> parts;
    for (size_t at = 0; at + 24 < bytes.size(); ++at) {
        int64_t length = 0;
        std::memcpy(&length, &bytes[at], 8);
        const bool zip = bytes[at + 8] == 0x78, blosc = bytes[at + 8] == 2;
        if ((zip || blosc) && length > 8 && length < int64_t(bytes.size() - at)) parts.push_back(at);
    }
    if (parts.empty()) return damaged(bytes, dice);
    const size_t at = parts[dice.below(parts.size())];
    const uint32_t size = dice.one_of<uint32_t>({0, 1, 0x7fffffff, 0xffffffff, 0x40000000, 2048});
    if (bytes[at + 8] == 0x78 && dice.chance(0.25)) {
        what = "a compressed part that unpacks to 3 GiB";
        int64_t length = 0;
        std::memcpy(&length, &bytes[at], 8);
        bytes.replace(at + 8, size_t(length), zip_bomb());
        put(bytes, at, int64_t(zip_bomb().size()));
        return bytes;
    }
    switch (dice.below(4)) {
    case 0:
        what = "length of a compressed part";
        put(bytes, at, dice.one_of<int64_t>({0, -1, 1, int64_t(1) << 40, INT64_MAX, INT64_MIN, -2048, 1 << 30}));
        break;
    case 1: what = "bytes that Blosc unpacks", put(bytes, at + 12, size); break;
    case 2: what = "blocks that Blosc unpacks", put(bytes, at + 16, size); break;
    default: what = "bytes that Blosc packed", put(bytes, at + 20, size);
    }
    return bytes;
}

std::string many_grids(int count)
{
    std::vector<GridBasePtr> grids;
    const auto first = ball("density", 2);
    for (int k = 0; k < count; ++k) {
        const auto grid = k == 0 ? first : openvdb::gridPtrCast<FloatGrid>(first->copyGrid());
        if (k > 0) grid->setName("grid" + std::to_string(k));
        grids.push_back(grid);
    }
    return as_bytes(grids, MetaMap(), openvdb::io::COMPRESS_NONE);
}

}  // namespace vdbcloud::test
