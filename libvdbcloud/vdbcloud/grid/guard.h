#pragma once
// Work on bytes of unknown origin, tried first where it can do no harm.
#include <cstdint>
#include <functional>
#include <string>

namespace vdbcloud {

struct GuardLimits {
    uint64_t memory_bytes = 0;  ///< of address space, beyond what this process has mapped
    double cpu_seconds = 0;     ///< of processor time
};

/// Runs `work` in a forked process under the limits, silent, and waits for it. Returns an empty string if it came to
/// its end; what it threw, if it threw; else what befell it, as the rest of a sentence about the file
/// ("needs more than 1024 MB ..."). `work` must not start threads nor wait for a lock of this process.
std::string run_guarded(const std::function<void()>& work, const GuardLimits&);

}  // namespace vdbcloud
