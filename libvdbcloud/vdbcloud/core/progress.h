#pragma once
// How the library talks while it works: callbacks that the program supplies. The library itself never prints.
#include "vdbcloud/core/error.h"

#include <functional>
#include <string>

namespace vdbcloud {

/// Called now and then with the fraction done, in [0, 1]; returns false when the caller wants the work to stop.
/// May be called from any thread. An empty function means that nobody watches.
using Progress = std::function<bool(double)>;

/// Tells `progress` (if any) the fraction done. Throws Cancelled if it answers false.
inline void report(const Progress& progress, double fraction)
{
    if (progress && !progress(fraction)) throw Cancelled();
}

/// Told one sentence about something that was put right or passed over; an empty function means nobody listens.
using Warn = std::function<void(const std::string&)>;

inline void warn(const Warn& to, const std::string& sentence)
{
    if (to) to(sentence);
}

}  // namespace vdbcloud
