#pragma once
// Fingerprints of bytes: XXH3, 128 bits. Not for security.
#include "vdbcloud/core/fwd.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

struct XXH3_state_s;

namespace vdbcloud {

/// XXH3 (128 bits) of all bytes added so far. The result does not depend on how calls of add() split the bytes.
class Digest {
public:
    Digest();
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

    std::string hex() const;   ///< 32 digits, equal to the output of `xxhsum -H128`
    std::string uuid() const;  ///< the digits of hex() in groups of 8-4-4-4-12

private:
    struct Free {
        void operator()(XXH3_state_s*) const;
    };
    std::unique_ptr<XXH3_state_s, Free> state_;
};

/// Fingerprint of a grid's transform, background, active topology and active values, in hex. Equal grids have equal
/// fingerprints on every little-endian machine. Name, metadata and inactive values have no effect.
std::string grid_digest(const FloatGrid&);
std::string grid_digest(const Vec3SGrid&);

}  // namespace vdbcloud
