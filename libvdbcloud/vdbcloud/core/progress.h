#pragma once
// Callbacks for progress and warnings, supplied by the program. The library itself never prints.
#include "vdbcloud/core/error.h"

#include <functional>
#include <string>

namespace vdbcloud {

/// Receives the fraction of the work done, in [0, 1], several times during the work. Returns false to cancel the work.
/// May be called from any thread. An empty function disables progress reports.
using Progress = std::function<bool(double)>;

/// Calls `progress`, unless empty, with the fraction done. Throws Cancelled if `progress` returns false.
inline void report(const Progress& progress, double fraction)
{
    if (progress && !progress(fraction)) throw Cancelled();
}

/// Receives one warning about repaired or ignored input, as one sentence. An empty function disables warnings.
using Warn = std::function<void(const std::string&)>;

/// Calls `to`, unless empty, with the sentence.
inline void warn(const Warn& to, const std::string& sentence)
{
    if (to) to(sentence);
}

}  // namespace vdbcloud
