#pragma once
// The number of threads that this process may use.

namespace vdbcloud::app {

/// The smallest of the limits of the processor affinity, the control group's quota (rounded up) and
/// SLURM_CPUS_PER_TASK; at least 1.
int allowed_threads();

}  // namespace vdbcloud::app
