#include "vdbcloud/scatter/channel_groups.h"

#include "vdbcloud/optics/channels.h"

#include <algorithm>
#include <optional>

namespace vdbcloud {

namespace {

/// Factor x such that b's light is x times a's light, if such a factor exists.
std::optional<double> solution_as(const ChannelInput& a, const ChannelInput& b)
{
    if (a.emission != b.emission || a.surfaces != b.surfaces) return std::nullopt;
    return multiple(a.light, b.light);
}

}  // namespace

std::optional<double> beams_as(const ChannelBeams& of, const ChannelBeams& as)
{
    if (of.extinction != as.extinction || !(of.albedo > 0)) return std::nullopt;
    return multiple(of.strength, as.strength);
}

std::vector<std::vector<const ChannelGroup*>> swept_together(const std::vector<ChannelGroup>& groups,
                                                             const std::array<double, 3>& extinction, bool scales)
{
    std::vector<std::vector<const ChannelGroup*>> together;
    const auto of = [&](const ChannelGroup& group) { return extinction[size_t(group.solves[0].channel)]; };
    for (const ChannelGroup& group : groups) {
        const auto same = std::find_if(together.begin(), together.end(),
                                       [&](const auto& others) { return !scales && of(*others[0]) == of(group); });
        if (same == together.end())
            together.push_back({&group});
        else
            same->push_back(&group);
    }
    return together;
}

std::vector<ChannelGroup> group_channels(const std::array<ChannelInput, 3>& input, bool apart)
{
    if (apart) return {{{{0, {{0, 1.0}}}}}, {{{1, {{1, 1.0}}}}}, {{{2, {{2, 1.0}}}}}};
    std::vector<ChannelGroup> groups;
    for (int c = 0; c < 3; ++c) {
        const ChannelInput& own = input[size_t(c)];
        const auto group = std::find_if(groups.begin(), groups.end(), [&](const ChannelGroup& g) {
            const ChannelInput& first = input[size_t(g.solves[0].channel)];
            return first.matrix == own.matrix && first.tint == own.tint && first.mixed == own.mixed;
        });
        if (group == groups.end()) {
            groups.push_back({{{c, {{c, 1.0}}}}});
            continue;
        }
        bool shared = false;
        for (auto& solve : group->solves)
            if (const auto x = solution_as(input[size_t(solve.channel)], own); x && !shared) {
                solve.shared.emplace_back(c, *x);
                shared = true;
            }
        if (!shared) group->solves.push_back({c, {{c, 1.0}}});
    }
    return groups;
}

}  // namespace vdbcloud
