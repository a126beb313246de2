#include "vdbcloud/exchange/nanovdb_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/guarded_bytes.h"

#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <nanovdb/util/IO.h>
#pragma GCC diagnostic pop

#include <array>
#include <cmath>

namespace vdbcloud {

namespace {

/// A grid as plain numbers: leaves of 8^3 voxels, and tiles of one value. `components` values each.
struct Plain {
    std::string name;
    uint32_t components = 1, grid_class = 0;
    std::array<double, 12> map{};  // world of index 0, then of the three steps
    std::vector<float> background;
    std::vector<int32_t> leaf_origins, tile_origins, tile_edges;
    std::vector<uint64_t> masks;  // 8 words a leaf
    std::vector<float> values, tile_values;
};

template<typename T>
void append(std::vector<float>& to, const T& value)
{
    if constexpr (std::is_arithmetic_v<T>)
        to.push_back(float(value));
    else
        for (int a = 0; a < 3; ++a) to.push_back(float(value[a]));
}

void append(std::vector<int32_t>& to, const nanovdb::Coord& at) { to.insert(to.end(), {at[0], at[1], at[2]}); }

template<typename Leaf>
void take_leaf(const Leaf& leaf, Plain& plain)
{
    append(plain.leaf_origins, leaf.origin());
    for (uint32_t word = 0; word < 8; ++word) {
        uint64_t mask = 0;
        for (uint32_t bit = 0; bit < 64; ++bit)
            if (leaf.valueMask().isOn(64 * word + bit)) mask |= uint64_t(1) << bit;
        plain.masks.push_back(mask);
    }
    for (uint32_t at = 0; at < 512; ++at) append(plain.values, leaf.getValue(at));
}

template<typename T>
void take_tile(const nanovdb::Coord& origin, int32_t edge, const T& value, Plain& plain)
{
    append(plain.tile_origins, origin);
    plain.tile_edges.push_back(edge);
    append(plain.tile_values, value);
}

/// An internal node: its children, and active tiles of `edge` voxels.
template<typename Node, typename Child>
void take_node(const Node& node, int32_t edge, Plain& plain, const Child& child)
{
    const auto* data = node.data();
    for (uint32_t at = 0; at < Node::SIZE; ++at)
        if (data->mChildMask.isOn(at))
            child(*data->getChild(at));
        else if (data->mValueMask.isOn(at))
            take_tile(node.offsetToGlobalCoord(at), edge, data->getValue(at), plain);
}

template<typename BuildT>
Plain plain_of(const nanovdb::NanoGrid<BuildT>& grid)
{
    Plain plain;
    plain.name = grid.gridName();
    plain.grid_class = uint32_t(grid.gridClass());
    const auto world = [&](double i, double j, double k) { return grid.indexToWorld(nanovdb::Vec3d(i, j, k)); };
    const nanovdb::Vec3d points[] = {world(0, 0, 0), world(1, 0, 0), world(0, 1, 0), world(0, 0, 1)};
    for (size_t k = 0; k < 12; ++k) plain.map[k] = points[k / 3][int(k % 3)] - (k < 3 ? 0 : points[0][int(k % 3)]);
    append(plain.background, grid.tree().background());
    plain.components = uint32_t(plain.background.size());
    const auto* root = grid.tree().root().data();
    for (uint32_t t = 0; t < root->mTableSize; ++t) {
        const auto* tile = root->tile(t);
        if (tile->isChild())
            take_node(*root->getChild(tile), 128, plain, [&](const auto& lower) {
                take_node(lower, 8, plain, [&](const auto& leaf) { take_leaf(leaf, plain); });
            });
        else if (tile->state)
            take_tile(tile->origin(), 4096, tile->value, plain);
    }
    return plain;
}

/// Null for a type that is no number or vector of three.
bool plain_grid(const nanovdb::GridHandle<>& handle, Plain& plain)
{
    const auto take = [&](const auto* grid) {
        if (!grid) throw InputError("damaged NanoVDB file: a grid is not of the type that its header says");
        plain = plain_of(*grid);
        return true;
    };
    switch (handle.gridMetaData()->gridType()) {
    case nanovdb::GridType::Float: return take(handle.grid<float>());
    case nanovdb::GridType::Double: return take(handle.grid<double>());
    case nanovdb::GridType::Fp4: return take(handle.grid<nanovdb::Fp4>());
    case nanovdb::GridType::Fp8: return take(handle.grid<nanovdb::Fp8>());
    case nanovdb::GridType::Fp16: return take(handle.grid<nanovdb::Fp16>());
    case nanovdb::GridType::FpN: return take(handle.grid<nanovdb::FpN>());
    case nanovdb::GridType::Vec3f: return take(handle.grid<nanovdb::Vec3f>());
    case nanovdb::GridType::Vec3d: return take(handle.grid<nanovdb::Vec3d>());
    default: return false;
    }
}

void send(ByteChannel& channel, const Plain& plain)
{
    channel.put(plain.name);
    channel.put(std::vector<uint32_t>{plain.components, plain.grid_class});
    channel.put(std::vector<double>(plain.map.begin(), plain.map.end()));
    channel.put(plain.background);
    channel.put(plain.leaf_origins);
    channel.put(plain.masks);
    channel.put(plain.values);
    channel.put(plain.tile_origins);
    channel.put(plain.tile_edges);
    channel.put(plain.tile_values);
}

Plain receive(ByteChannel& channel)
{
    Plain plain;
    plain.name = printable(channel.get_text());
    const auto numbers = channel.get<uint32_t>();
    const auto map = channel.get<double>();
    plain.background = channel.get<float>();
    plain.leaf_origins = channel.get<int32_t>();
    plain.masks = channel.get<uint64_t>();
    plain.values = channel.get<float>();
    plain.tile_origins = channel.get<int32_t>();
    plain.tile_edges = channel.get<int32_t>();
    plain.tile_values = channel.get<float>();
    const size_t n = numbers.size() == 2 ? numbers[0] : 0, leaves = plain.masks.size() / 8,
                 tiles = plain.tile_edges.size();
    if ((n != 1 && n != 3) || map.size() != 12 || plain.background.size() != n ||
        plain.leaf_origins.size() != 3 * leaves || plain.values.size() != 512 * n * leaves ||
        plain.tile_origins.size() != 3 * tiles || plain.tile_values.size() != n * tiles)
        throw InputError("the reader of this format ended too early");
    plain.components = uint32_t(n);
    plain.grid_class = numbers[1];
    std::copy(map.begin(), map.end(), plain.map.begin());
    for (const auto* origins : {&plain.leaf_origins, &plain.tile_origins})
        for (const int32_t at : *origins)
            if (std::abs(double(at)) >= 1 << 30 || at % 8 != 0)
                throw InputError("damaged NanoVDB file: expected blocks at multiples of 8, below 2^30");
    return plain;
}

std::shared_ptr<Transform> transform_of(const Plain& plain)
{
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int row = 0; row < 3; ++row)
        for (int c = 0; c < 3; ++c) matrix[row][c] = plain.map[size_t(3 * (row + 1) + c)];
    for (int c = 0; c < 3; ++c) matrix[3][c] = plain.map[size_t(c)];
    double volume = 1;
    bool fine = true;
    for (int row = 0; row < 3; ++row) {
        const double edge = Vec3d(matrix[row][0], matrix[row][1], matrix[row][2]).length();
        fine = fine && edge >= 1e-6 && edge <= 1e6 && std::abs(matrix[3][row]) <= 1e12;
        volume *= edge;
    }
    if (!fine || !(std::abs(matrix.det()) > 1e-9 * volume))
        throw InputError("grid '" + plain.name + "': expected a transform with voxel edges of 1e-6 to 1e6 world units");
    return Transform::createLinearTransform(matrix);
}

template<typename GridT>
GridBasePtr grid_of(const Plain& plain)
{
    using T = typename GridT::ValueType;
    const auto value = [&](const std::vector<float>& values, size_t at) {
        if constexpr (std::is_same_v<T, float>)
            return values[at];
        else
            return T(values[3 * at], values[3 * at + 1], values[3 * at + 2]);
    };
    auto grid = GridT::create(value(plain.background, 0));
    grid->setName(plain.name);
    grid->setTransform(transform_of(plain));
    if (plain.grid_class == uint32_t(nanovdb::GridClass::LevelSet)) grid->setGridClass(openvdb::GRID_LEVEL_SET);
    if (plain.grid_class == uint32_t(nanovdb::GridClass::FogVolume)) grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (plain.grid_class == uint32_t(nanovdb::GridClass::Staggered)) grid->setGridClass(openvdb::GRID_STAGGERED);
    const auto at = [](const std::vector<int32_t>& origins, size_t k) {
        return openvdb::Coord(origins[3 * k], origins[3 * k + 1], origins[3 * k + 2]);
    };
    for (size_t t = 0; t < plain.tile_edges.size(); ++t) {
        const int edge = plain.tile_edges[t];
        const openvdb::Index level = edge == 8 ? 1 : edge == 128 ? 2 : 3;
        grid->tree().addTile(level, at(plain.tile_origins, t), value(plain.tile_values, t), true);
    }
    for (size_t k = 0; k < plain.masks.size() / 8; ++k) {
        auto* leaf = grid->tree().touchLeaf(at(plain.leaf_origins, k));
        for (openvdb::Index v = 0; v < 512; ++v)
            if (plain.masks[8 * k + v / 64] >> (v % 64) & 1)
                leaf->setValueOn(v, value(plain.values, 512 * k + v));
            else
                leaf->setValueOff(v, value(plain.values, 512 * k + v));
    }
    return grid;
}

/// What the guarded process does.
void send_file(const std::string& path, ByteChannel& channel)
{
    const auto handles = nanovdb::io::readGrids(path);
    std::vector<std::string> said;
    std::vector<Plain> grids;
    for (const auto& handle : handles) {
        Plain plain;
        if (plain_grid(handle, plain))
            grids.push_back(std::move(plain));
        else
            said.push_back(std::string("grid '") + handle.gridMetaData()->shortGridName() + "' of type " +
                           nanovdb::toStr(handle.gridMetaData()->gridType()) + " is passed over");
    }
    channel.put(said);
    channel.put(std::vector<uint64_t>{grids.size()});
    for (const Plain& plain : grids) send(channel, plain);
}

}  // namespace

NanoGrids read_nanovdb(const std::string& path)
{
    ByteChannel channel;
    read_guarded(path, [&] { send_file(path, channel); });
    NanoGrids read;
    try {
        for (const std::string& line : channel.get_texts()) read.said.push_back(printable(line, 400));
        const auto count = channel.get<uint64_t>();
        for (uint64_t k = 0; k < (count.empty() ? 0 : count[0]); ++k) {
            const Plain plain = receive(channel);
            read.grids.push_back(plain.components == 1 ? grid_of<FloatGrid>(plain) : grid_of<Vec3SGrid>(plain));
        }
    } catch (const InputError& e) {
        throw InputError(printable(path, 4096) + ": " + e.what());
    }
    return read;
}

}  // namespace vdbcloud
