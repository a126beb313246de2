#pragma once
// The functions behind the table of judge.cc. Private to hard/.
#include "hard/judge.h"

namespace vdbcloud::test::invariant_of {

Verdict turned(Chain&, const World&, const Seen&);
Verdict mirrored(Chain&, const World&, const Seen&);
Verdict relabelled(Chain&, const World&, const Seen&);
Verdict shifted(Chain&, const World&, const Seen&);
Verdict rescaled(Chain&, const World&, const Seen&);
Verdict brighter(Chain&, const World&, const Seen&);
Verdict threads(Chain&, const World&, const Seen&);
Verdict denser(Chain&, const World&, const Seen&);
Verdict lights(Chain&, const World&, const Seen&);
Verdict grey(Chain&, const World&, const Seen&);
Verdict half(Chain&, const World&, const Seen&);
Verdict inputs(Chain&, const World&, const Seen&);
Verdict finite(Chain&, const World&, const Seen&);
Verdict bounds(Chain&, const World&, const Seen&);
Verdict balance(Chain&, const World&, const Seen&);
Verdict furnace(Chain&, const World&, const Seen&);
Verdict lines(Chain&, const World&, const Seen&);
Verdict beams(Chain&, const World&, const Seen&);
Verdict path(Chain&, const World&, const Seen&);

}  // namespace vdbcloud::test::invariant_of
