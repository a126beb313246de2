#include "vdbcloud/scatter/streaming.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/active_slots.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// Largest 3 D / l. At 30 dark ends of ducts still have negative fluence; at 3 pictures of clouds with thin edges
/// change by 1 %, some for the worse.
constexpr double widest = 10;

}  // namespace

std::vector<float> streaming_limit(const P1Cells& p1, const OrdinateFrame& frame)
{
    const Blocks& blocks = p1.blocks();
    const Ordinates ordinate = ordinates(OrdinateKind::Product, streaming_directions, 1, frame.polar, frame.layered);
    SweepSet set;
    set.source_terms = set.moment_terms = 1;
    set.direction = ordinate.direction;
    for (const double weight : ordinate.weight) set.weight.push_back(float(weight));
    set.source_basis.assign(set.count(), 1.0f);
    set.moment_basis.assign(set.count(), float(1 / (4 * pi)));
    std::vector<float> sigma(blocks.slots(), 0.0f);
    std::vector<std::vector<float>> one(1, sigma);  // a source of 1, over sigma
    each_active(blocks, [&](size_t slot) {
        sigma[slot] = float(p1.sigma_tr(slot));
        one[0][slot] = float(1 / p1.sigma_tr(slot));
    });
    SweepResult flown;
    TransportSweep(p1.index(), {}).run(set, {&sigma, &one, true}, flown);
    std::vector<float> factor(blocks.slots(), 1.0f);
    each_active(blocks, [&](size_t slot) {
        factor[slot] = float(std::min(widest * double(flown.moments[0][slot]) * p1.sigma_tr(slot), 1.0));
    });
    return factor;
}

}  // namespace vdbcloud
