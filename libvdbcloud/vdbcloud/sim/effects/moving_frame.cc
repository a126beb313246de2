// A box that moves over the ground with a constant velocity (Galilean): the winds of the fields are relative to the
// box, so that they are small where it moves with the mean wind, and less is lost in transport. Files and budgets have
// winds over the ground, and files have the box where it is. Floor, sources and friction are the ground's.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

void check(const Parameters& p)
{
    for (const size_t axis : {0, 1}) {
        const std::string name = std::string("frame velocity along ") + "xy"[axis];
        if (!magnitude(allowed_speed).holds(p.frame[axis])) refuse(name, p.frame[axis], "-500..500 m/s");
        if (p.frame[axis] == 0) continue;
        if (p.lattice.flat(int(axis))) refuse(name, p.frame[axis], "0, as the box has one cell along this axis");
        if (p.lattice.side[axis] == Side::Wall)
            refuse(name, p.frame[axis], "0, or sides that are periodic or open: walls stand on the ground");
    }
}

}  // namespace

Effect moving_frame()
{
    return {"moving frame",
            "",
            {},
            [](const Parameters& p) { return p.frame[0] != 0 || p.frame[1] != 0; },
            check,
            nullptr,
            {},
            0,
            "frame-velocity U,V"};
}

}  // namespace vdbcloud::sim::effect
