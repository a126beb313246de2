#pragma once
// How much memory this process holds, how much more the system gives, and what goes back to the system.
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

/// Gives free memory of the heap back to the system, where the C library can. Arrays of up to 32 MB leave holes there
/// that stay resident, for arrays of other sizes do not fill them.
void give_back_free_memory();

}  // namespace vdbcloud
