#pragma once
// What a run would take: estimates of --dry-run, and the refusal of what cannot fit the memory.
#include "app.h"

#include "vdbcloud/core/workload.h"

#include <string>

namespace vdbcloud::app {

/// Work and memory of a run. Make one before the work that finds them, as it notes what the process holds by then.
class Plan {
public:
    Plan();

    Workload work;
    double bytes = 0;     ///< that the run holds at its peak, beyond what the process held when the plan was made
    std::string way_out;  ///< what to change if the memory does not suffice: "a smaller --size"

    /// Resident memory of the whole process at the peak [bytes].
    double peak() const;
    /// Empty, or a sentence: the memory needed, the memory there is, and the way out. An estimate may be 1.3 times too
    /// large, so that a run of which 1 / 1.3 fits counts as fitting.
    std::string lack() const;

private:
    double held_, most_;
};

/// The values of a grid that reading and writing go through [bytes].
double value_bytes(const GridBase&);

/// Ends a dry run: reports the plan and what was read as "estimate", and prints both. `task`: "render 512x512 pixels".
void tell(App&, const Plan&, const std::string& task);

/// Throws InputError if the plan's memory is more than the system gives. Call before the first large array.
void require_memory(const Plan&);

}  // namespace vdbcloud::app
