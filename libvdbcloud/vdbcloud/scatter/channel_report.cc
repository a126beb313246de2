#include "vdbcloud/scatter/channel_report.h"

namespace vdbcloud {

ChannelReport multiple_of(const ChannelReport& from, double scale)
{
    ChannelReport r = from;
    r.scale = scale;
    for (double* power :
         {&r.deposited, &r.beam_in, &r.beam_out, &r.emitted, &r.reflected, &r.transmitted, &r.budget.sky_in,
          &r.budget.to_ground, &r.budget.absorbed, &r.budget.smallest, &r.budget.largest, &r.planes.reentered,
          &r.planes.from_ground, &r.ground.direct, &r.ground.diffuse, &r.ground.sent_up, &r.ground.absorbed})
        *power *= scale;
    for (auto* powers : {&r.budget.out, &r.planes.out, &r.planes.sky_in})
        for (double& power : *powers) power *= scale;
    if (r.lines >= 0) r.lines *= scale;
    return r;
}

void set_sides(const VoxelIndex& index, const std::optional<Vec3d>& to_sun, int top, ChannelReport& report)
{
    report.reflected = report.transmitted = 0;
    for (int face = 0; face < 6; ++face) {
        const double side = to_sun ? to_sun->dot(index.axis(face / 2)) * (face % 2 ? 1 : -1) : face == top;
        (side > 1e-9 ? report.reflected : report.transmitted) += report.planes.out[size_t(face)];
    }
}

}  // namespace vdbcloud
