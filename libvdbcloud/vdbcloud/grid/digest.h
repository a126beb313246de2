#pragma once
// Fingerprints of bytes: fast, 128 bits, equal on every little-endian machine. Not for security.
#include "vdbcloud/core/fwd.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace vdbcloud {

/// Four lanes of 64 bits, each taking every fourth word by a product and a shift; mixed at the end. One
/// changed word always changes its lane, as each step is a bijection of it.
class Digest {
public:
    void add(const void* bytes, size_t count);

    template<typename T>
    void add_value(const T& x)
    {
        add(&x, sizeof x);
    }

    void add_text(const std::string& text)
    {
        add_value(uint64_t(text.size()));
        add(text.data(), text.size());
    }

    std::string hex() const;   ///< 32 digits
    std::string uuid() const;  ///< the same as 8-4-4-4-12 digits

private:
    void block(const unsigned char* bytes);

    uint64_t lane_[4] = {0x243f6a8885a308d3ull, 0x13198a2e03707344ull, 0xa4093822299f31d0ull, 0x082efa98ec4e6c89ull};
    unsigned char rest_[32] = {};
    uint64_t count_ = 0;  // bytes so far; the last count_ % 32 are in rest_
};

/// A fingerprint of a grid's transform, active topology and values, equal for equal grids on any machine, in
/// hex.
std::string grid_digest(const FloatGrid&);

}  // namespace vdbcloud
