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

/// what() of the current exception.
std::string what_is_thrown();

/// Runs `work` in a forked process under the limits, silent, and waits for it. Returns an empty string if it came to
/// its end; if it threw, what `describe` says of the exception, which is the current one then (rethrow it to look);
/// else what befell it, as the rest of a sentence about the file ("needs more than 1024 MB ...").
///
/// Nothing that `work` built is destroyed, whether it returns or throws: destroying trees takes the threads of this
/// process, which the forked one does not have. So `work` must not wait for threads either, nor for a lock.
std::string run_guarded(const std::function<void()>& work, const GuardLimits&,
                        const std::function<std::string()>& describe = what_is_thrown);

}  // namespace vdbcloud
