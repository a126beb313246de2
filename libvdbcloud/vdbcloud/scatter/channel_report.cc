#include "vdbcloud/scatter/channel_report.h"

namespace vdbcloud {

ChannelReport multiple_of(const ChannelReport& from, double scale)
{
    ChannelReport r = from;
    r.scale = scale;
    for (double* power :
         {&r.deposited, &r.beam_in, &r.beam_out, &r.emitted, &r.planes.reflected, &r.budget.sky_in, &r.budget.to_ground,
          &r.budget.absorbed, &r.budget.smallest, &r.budget.largest, &r.planes.reentered, &r.planes.from_ground,
          &r.ground.direct, &r.ground.diffuse, &r.ground.sent_up, &r.ground.absorbed})
        *power *= scale;
    for (auto* powers : {&r.budget.out, &r.planes.out, &r.planes.sky_in})
        for (double& power : *powers) power *= scale;
    if (r.lines >= 0) r.lines *= scale;
    return r;
}

}  // namespace vdbcloud
