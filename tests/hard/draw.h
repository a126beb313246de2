#pragma once
// Random numbers that are the same on every machine: SplitMix64 (Steele, Lea, Flood 2014).
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace vdbcloud::test {

class Draw {
public:
    explicit Draw(uint64_t seed) : state_(seed)
    {
        state_ = bits() ^ 0x632be59bd9b4e019u;  // streams of consecutive seeds must not overlap
    }

    uint64_t bits()
    {
        uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    double uniform() { return double(bits() >> 11) * 0x1p-53; }                         ///< in [0, 1)
    double uniform(double low, double high) { return low + (high - low) * uniform(); }  ///< in [low, high)
    double logarithmic(double low, double high) { return low * std::pow(high / low, uniform()); }
    int whole(int low, int high) { return low + int(bits() % uint64_t(high - low + 1)); }  ///< low and high included
    bool chance(double p) { return uniform() < p; }

    template<typename T>
    T one_of(std::initializer_list<T> all)
    {
        return all.begin()[bits() % all.size()];
    }

private:
    uint64_t state_;
};

}  // namespace vdbcloud::test
