#pragma once
// The whole state of a run in one file, from which the run continues with equal bits.
#include "vdbcloud/sim/run_record.h"

#include <string>

namespace vdbcloud::sim {

/// Writes to a temporary and renames it, so that a killed run does not damage the previous checkpoint. `frame` is the
/// number of the last frame that is on disk; `statistics` are bytes of the caller. Throws IoError.
void write_checkpoint(const std::string& path, const Simulation&, const RunRecord&, const Schedule&, int frame,
                      const std::string& statistics = {});

/// Restores a simulation and returns the frame. `record` and `schedule` are those of the run that continues. Values
/// that differ are refused, or with `change` noted in the record: see continue_record(). Frames that follow an earlier
/// change keep their times; where --every differs, or the earlier run ended between two frames, frames follow from the
/// checkpoint on. `statistics`, where not null, takes the caller's bytes. Throws IoError if the file cannot be read, is
/// damaged (it carries a checksum) or no checkpoint; UsageError for another run.
int read_checkpoint(const std::string& path, Simulation&, RunRecord& record, Schedule& schedule, bool change,
                    std::string* statistics = nullptr);

/// Where a checkpoint stands.
struct CheckpointPlace {
    int frame;    ///< the last that is on disk
    double time;  ///< [s]
};

/// As read_checkpoint(), without the state: neither its size nor the checksum is looked at.
CheckpointPlace read_checkpoint_place(const std::string& path, RunRecord& record, Schedule& schedule, bool change);

}  // namespace vdbcloud::sim
