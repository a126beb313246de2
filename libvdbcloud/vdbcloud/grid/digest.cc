#include "vdbcloud/grid/digest.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <xxhash.h>

#include <cstdio>
#include <new>

namespace vdbcloud {

Digest::Digest() : state_(XXH3_createState())
{
    if (!state_ || XXH3_128bits_reset(state_.get()) != XXH_OK) throw std::bad_alloc();
}

void Digest::Free::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

void Digest::add(const void* data, size_t count) { XXH3_128bits_update(state_.get(), data, count); }

std::string Digest::hex() const
{
    const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

std::string Digest::uuid() const
{
    std::string text = hex();
    for (const int at : {8, 13, 18, 23}) text.insert(at, "-");
    return text;
}

namespace {

template<typename GridT>
std::string digest_of(const GridT& grid)
{
    using Value = typename GridT::ValueType;
    static_assert(sizeof(Value) % sizeof(float) == 0, "values without padding");
    Digest digest;
    const auto affine = grid.transform().baseMap()->getAffineMap();
    const auto matrix = affine ? affine->getMat4() : openvdb::Mat4d::identity();
    digest.add(matrix.asPointer(), 16 * sizeof(double));
    digest.add_text(affine ? "" : grid.transform().mapType());
    digest.add_value(grid.background());

    for_each_active_tile(grid, [&](const auto& tile) {
        digest.add_value(tile.getCoord());
        digest.add_value(uint32_t(tile.getDepth()));
        digest.add_value(*tile);
    });
    constexpr int size = GridT::TreeType::LeafNodeType::SIZE;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (leaf->getValueMask().isOff()) continue;  // not part of the active topology
        digest.add_value(leaf->origin());
        Value values[size];
        const Value* all = leaf->buffer().data();
        for (int k = 0; k < size; ++k) values[k] = leaf->isValueOn(k) ? all[k] : Value(0);
        for (openvdb::Index word = 0; word < size / 64; ++word)
            digest.add_value(uint64_t(leaf->getValueMask().template getWord<openvdb::Index64>(word)));
        digest.add(values, sizeof values);
    }
    return digest.hex();
}

}  // namespace

std::string grid_digest(const FloatGrid& grid) { return digest_of(grid); }
std::string grid_digest(const Vec3SGrid& grid) { return digest_of(grid); }

}  // namespace vdbcloud
