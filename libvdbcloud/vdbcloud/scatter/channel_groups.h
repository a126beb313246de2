#pragma once
// Which of the three channels share a matrix, and which a solution. Private to scatter/.
#include <array>
#include <utility>
#include <vector>

namespace vdbcloud {

/// What one channel is solved with. Fields are compared by address.
struct ChannelInput {
    std::array<double, 2> matrix{};  ///< extinction and albedo
    const std::vector<float>* tint = nullptr;
    const std::vector<float>* emission = nullptr;
    std::vector<double> light;  ///< strengths of everything that shines, emission among it
};

/// Channels with one matrix, and within them those with one solution.
struct ChannelGroup {
    struct Solve {
        int channel;                                 ///< whose light it is solved for
        std::vector<std::pair<int, double>> shared;  ///< channels that are a multiple of it, itself with 1
    };
    std::vector<Solve> solves;
};

/// A channel shares another's solution if matrix and emission are the same and its light is a multiple x >= 0 of the
/// other's.
std::vector<ChannelGroup> group_channels(const std::array<ChannelInput, 3>&);

}  // namespace vdbcloud
