#pragma once
// Finds channels that share a matrix or a solution, so that each solve runs once. Private to scatter/.
#include <array>
#include <optional>
#include <utility>
#include <vector>

namespace vdbcloud {

/// Input of one channel's solve. Tint and emission are compared by address.
struct ChannelInput {
    std::array<double, 2> matrix{};  ///< extinction and albedo
    const std::vector<float>* tint = nullptr;
    const std::vector<float>* emission = nullptr;
    const void* mixed = nullptr;     ///< overlapping media, compared by address
    std::vector<double> light;       ///< strengths of all sources: lights, sky, emission
    std::vector<double> surfaces{};  ///< reflectances of solids
};

/// Channels that share one matrix, divided into solves whose channels share one solution.
struct ChannelGroup {
    struct Solve {
        int channel;                                 ///< channel whose light is solved for
        std::vector<std::pair<int, double>> shared;  ///< (channel, multiple); includes (`channel`, 1)
    };
    std::vector<Solve> solves;
};

/// What a channel's beams depend on, where all light is scattered alike into all directions, by one albedo.
struct ChannelBeams {
    double extinction = 0, albedo = 0;
    std::vector<double> strength;  ///< of each light
};
/// Factor of the fluence of beams by which those of a channel follow from those of another, if there is one. What
/// collides and is scattered has the ratio of the albedos as a factor besides.
std::optional<double> beams_as(const ChannelBeams& of, const ChannelBeams& as);

/// Groups whose channels have one extinction in the scaling of sweeps, so that one sweep serves all; each other group
/// alone. `extinction` at density 1 by channel; `scales`: the scaling makes extinction depend on the albedo.
std::vector<std::vector<const ChannelGroup*>> swept_together(const std::vector<ChannelGroup>&,
                                                             const std::array<double, 3>& extinction, bool scales);

/// Channels share a solution if matrix, emission and surfaces are equal and their lights differ only by a factor x >=
/// 0; none does with `apart`.
std::vector<ChannelGroup> group_channels(const std::array<ChannelInput, 3>&, bool apart = false);

}  // namespace vdbcloud
