#pragma once
// Damage to bytes, as a failing disk or network, a faulty program or an attacker causes it.
#include "vdbcloud/core/random.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <string>

namespace vdbcloud::test {

/// Random numbers as a function of a seed and a position in a sequence.
class Dice {
public:
    explicit Dice(uint64_t seed) : seed_(seed) {}
    uint64_t bits() { return hash_bits(seed_, ++count_); }
    size_t below(size_t n) { return size_t(bits() % n); }
    bool chance(double p) { return uniform(bits()) < p; }
    template<typename T>
    T one_of(std::initializer_list<T> all)
    {
        return all.begin()[below(all.size())];
    }

private:
    uint64_t seed_, count_ = 0;
};

template<typename T>
void put(std::string& bytes, size_t at, T value)
{
    if (at + sizeof value <= bytes.size()) std::memcpy(&bytes[at], &value, sizeof value);
}

/// The bytes, not empty, with damage in one place.
inline std::string damaged(std::string bytes, Dice& dice)
{
    const size_t reach = dice.below(10) < 6 ? std::min<size_t>(bytes.size(), 4096) : bytes.size();
    const size_t at = dice.below(reach), length = 1 + dice.below(64);
    static const int64_t numbers[] = {0,
                                      1,
                                      -1,
                                      2,
                                      127,
                                      255,
                                      256,
                                      32767,
                                      65535,
                                      0x7fffffff,
                                      int64_t(0x80000000),
                                      int64_t(0xffffffff),
                                      0x7fffffffffffffff,
                                      1000000000,
                                      4096,
                                      -4096};
    static const float floats[] = {NAN, INFINITY, -INFINITY, 1e38f, -1.0f, 1e-40f, 0.0f};
    switch (dice.below(12)) {
    case 0: bytes[at] = char(bytes[at] ^ (1 << dice.below(8))); break;
    case 1:
        for (int k = 0; k < 8; ++k) bytes[dice.below(reach)] ^= char(1 << dice.below(8));
        break;
    case 2: bytes[at] = char(dice.bits()); break;
    case 3: bytes.resize(dice.below(bytes.size())); break;
    case 4: put(bytes, at, int32_t(numbers[dice.below(std::size(numbers))])); break;
    case 5: put(bytes, at, numbers[dice.below(std::size(numbers))]); break;
    case 6: put(bytes, at, floats[dice.below(std::size(floats))]); break;
    case 7: std::fill(bytes.begin() + at, bytes.begin() + std::min(bytes.size(), at + length), '\0'); break;
    case 8: bytes.insert(at, bytes.substr(dice.below(bytes.size()), length)); break;
    case 9: bytes.erase(at, 1 + dice.below(8)); break;
    case 10: bytes.insert(at, std::string(1 + dice.below(8), char(dice.bits()))); break;
    default: {
        const size_t other = dice.below(bytes.size());
        const std::string part = bytes.substr(other, length);
        bytes.replace(at, part.size(), part);
    }
    }
    return bytes;
}

/// The head of one file, not empty, and the tail of another.
inline std::string spliced(const std::string& head, const std::string& tail, Dice& dice)
{
    const size_t at = dice.below(head.size());
    return head.substr(0, at) + tail.substr(dice.chance(0.5) ? std::min(at, tail.size()) : dice.below(tail.size() + 1));
}

}  // namespace vdbcloud::test
