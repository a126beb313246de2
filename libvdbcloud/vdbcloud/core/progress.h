#pragma once
// One callback for two needs: showing how far a long loop is, and stopping it.
#include "vdbcloud/core/error.h"

#include <functional>

namespace vdbcloud {

/// Called now and then with the fraction done, in [0, 1]; returns false when the caller wants the work to stop.
/// May be called from any thread. An empty function means that nobody watches.
using Progress = std::function<bool(double)>;

/// Tells `progress` (if any) the fraction done. Throws Cancelled if it answers false.
inline void report(const Progress& progress, double fraction)
{
    if (progress && !progress(fraction)) throw Cancelled();
}

}  // namespace vdbcloud
