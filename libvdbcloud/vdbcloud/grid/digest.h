#pragma once
// Fingerprints of bytes: XXH3, 128 bits. Not for security.
#include "vdbcloud/core/fwd.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

struct XXH3_state_s;

namespace vdbcloud {

/// XXH3 (128 bits) of all bytes added so far, however they were cut into pieces.
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

    std::string hex() const;   ///< 32 digits, those that `xxhsum -H128` prints
    std::string uuid() const;  ///< the same as 8-4-4-4-12 digits

private:
    struct Free {
        void operator()(XXH3_state_s*) const;
    };
    std::unique_ptr<XXH3_state_s, Free> state_;
};

/// Fingerprint of a grid's transform, background, active topology and active values, in hex. Equal for equal grids on
/// every little-endian machine; name, metadata and inactive values do not count.
std::string grid_digest(const FloatGrid&);

}  // namespace vdbcloud
