#pragma once
// How many threads this process was given.

namespace vdbcloud::app {

/// The least of what the processor affinity, the control group's quota (rounded up) and SLURM_CPUS_PER_TASK allow; at
/// least 1.
int allowed_threads();

}  // namespace vdbcloud::app
