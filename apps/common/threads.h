#pragma once
// The number of threads that this process may use.

namespace vdbcloud::app {

/// The smallest of the limits of the processor affinity, the control group's quota (rounded up) and
/// SLURM_CPUS_PER_TASK; at least 1.
int allowed_threads();

/// How many of `wanted` threads the system lets this process have. Fewer where the address space or the number of
/// processes is limited (ulimit -v, ulimit -u).
int startable_threads(int wanted);

}  // namespace vdbcloud::app
