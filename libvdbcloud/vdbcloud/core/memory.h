#pragma once
// How much memory this process holds, and how much more the system gives.
#include <optional>
#include <string>

namespace vdbcloud {

/// Resident memory of this process [bytes]: now, and at most since it started; 0 where the system does not say.
double memory_held();
double most_memory_held();

/// Memory that this process can still take, and what limits it.
struct MemoryLeft {
    double bytes;
    std::string limit;  ///< "the machine", "the limit of the address space (ulimit -v)", "the control group"
};

/// The least of: what the machine has available and free swap, the limit of the address space less the address space in
/// use, and the limits of the control groups less their use. None where the system does not say.
std::optional<MemoryLeft> memory_left();

}  // namespace vdbcloud
