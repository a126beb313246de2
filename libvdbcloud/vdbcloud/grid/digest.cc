#include "vdbcloud/grid/digest.h"

#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace vdbcloud {

void Digest::block(const unsigned char* bytes)
{
    uint64_t word[4];
    std::memcpy(word, bytes, sizeof word);
    for (int k = 0; k < 4; ++k) {
        // The product carries changes upwards only, so its high half is brought down for the next round.
        const uint64_t product = (lane_[k] ^ word[k]) * 0x9fb21c651e98df25ull;
        lane_[k] = product ^ (product >> 32);
    }
}

void Digest::add(const void* data, size_t count)
{
    const auto* bytes = static_cast<const unsigned char*>(data);
    if (const size_t held = count_ % 32; held + count < 32 || held > 0) {
        const size_t taken = std::min(count, 32 - held);
        std::memcpy(rest_ + held, bytes, taken);
        count_ += taken;
        bytes += taken;
        count -= taken;
        if (count_ % 32 != 0 || taken == 0) return;
        block(rest_);
    }
    for (; count >= 32; count -= 32, bytes += 32, count_ += 32) block(bytes);
    std::memcpy(rest_, bytes, count);
    count_ += count;
}

std::string Digest::hex() const
{
    Digest last = *this;
    const size_t held = count_ % 32;
    std::memset(last.rest_ + held, 0, 32 - held);
    last.block(last.rest_);
    const uint64_t a = hash_bits(count_, last.lane_[0], last.lane_[1], last.lane_[2], last.lane_[3]);
    const uint64_t b = hash_bits(a, last.lane_[3], last.lane_[2], last.lane_[1], last.lane_[0]);
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(a),
                  static_cast<unsigned long long>(b));
    return text;
}

std::string Digest::uuid() const
{
    std::string text = hex();
    for (const int at : {8, 13, 18, 23}) text.insert(at, "-");
    return text;
}

std::string grid_digest(const FloatGrid& grid)
{
    Digest digest;
    const auto affine = grid.transform().baseMap()->getAffineMap();
    const auto matrix = affine ? affine->getMat4() : openvdb::Mat4d::identity();
    digest.add(matrix.asPointer(), 16 * sizeof(double));
    digest.add_text(affine ? "" : grid.transform().mapType());
    digest.add_value(grid.background());

    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(FloatGrid::TreeType::DEPTH - 2);  // all above the leaves
    for (; tile; ++tile) {
        digest.add_value(tile.getCoord());
        digest.add_value(uint32_t(tile.getDepth()));
        digest.add_value(*tile);
    }
    constexpr int size = FloatGrid::TreeType::LeafNodeType::SIZE;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (leaf->getValueMask().isOff()) continue;  // a leaf without active voxels is topology of no one
        digest.add_value(leaf->origin());
        float values[size];
        const float* all = leaf->buffer().data();
        for (int k = 0; k < size; ++k) values[k] = leaf->isValueOn(k) ? all[k] : 0.0f;
        for (openvdb::Index word = 0; word < size / 64; ++word)
            digest.add_value(uint64_t(leaf->getValueMask().getWord<openvdb::Index64>(word)));
        digest.add(values, sizeof values);
    }
    return digest.hex();
}

}  // namespace vdbcloud
