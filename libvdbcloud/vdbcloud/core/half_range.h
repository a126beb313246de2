#pragma once
// Whether values survive as 16-bit floats.
#include <cstddef>

namespace vdbcloud {

inline constexpr float largest_half = 65504;
/// 6.1e-5: from here upwards halves have 11 bits; below they are 6e-8 apart and have fewer and fewer.
inline constexpr float smallest_full_half = 0x1p-14f;

/// Collects values and judges whether halves hold them.
class HalfRange {
public:
    void add(float);
    /// A value is above 65504 in magnitude, or is not a number.
    bool above() const { return above_; }
    /// Halves would round faint values away: more than an eighth of the values other than 0 are below 6.1e-5 and are
    /// not halves already. Soft edges of any cloud fall to 0: 2 to 5 % of the lit pixels of a picture are below that,
    /// next to bright ones, and lose nothing that can be seen.
    bool faint() const { return 8 * faint_ > lit_; }

private:
    bool above_ = false;
    std::size_t lit_ = 0, faint_ = 0;
};

}  // namespace vdbcloud
