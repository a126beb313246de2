#pragma once
// Runs work on untrusted bytes in a forked process with limits.
#include <cstdint>
#include <functional>
#include <string>

namespace vdbcloud {

struct GuardLimits {
    uint64_t memory_bytes = 0;  ///< address space [bytes] in addition to what this process has mapped
    double cpu_seconds = 0;     ///< processor time [s], at least 1
};

/// what() of the current exception.
std::string what_is_thrown();

/// Runs `work` in a forked process under the limits, without output, and waits for the end of that process.
///
/// Returns an empty string if `work` returned. If `work` threw, returns the text of `describe`, which runs with the
/// exception as the current one (rethrow it to examine it). If a limit or a signal ended the process, returns the end
/// of a sentence about the file ("malformed or too large: reading it takes more than 1024 MB of memory").
///
/// Objects that `work` built are never destroyed, whether `work` returns or throws. Destroying a tree needs the worker
/// threads of this process, and the forked process does not have them. For the same reason `work` must not wait for
/// threads or locks. Throws std::system_error if the system refuses a pipe, a process or its thread.
std::string run_guarded(const std::function<void()>& work, const GuardLimits&,
                        const std::function<std::string()>& describe = what_is_thrown);

}  // namespace vdbcloud
