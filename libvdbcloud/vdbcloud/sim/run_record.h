#pragma once
// What a run is, as one list of names and exact values. The metadata of frames hold the list, a checkpoint carries it,
// and a run that continues from a checkpoint compares it with its own.
#include "vdbcloud/sim/snapshot.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

/// One value of a run.
struct RunValue {
    std::string name;   ///< "heat_flux"
    std::string value;  ///< exact, as text
    bool can_change;    ///< the state of the air does not depend on it: another value can hold from a checkpoint on
};

/// The times of frames: frame `first` is at `start`, the others follow every `every` seconds up to `end`.
struct Schedule {
    double every = 10;  ///< [s], > 0
    double end = 0;     ///< of the run [s]
    int first = 0;      ///< 0, or the frame from which on `every` holds
    double start = 0;   ///< of frame `first` [s]

    double time_of(int frame) const;
    /// The last frame, which is at `end`.
    int last() const;
};

/// What frames hold and when they are, beside the parameters.
struct FramePlan {
    SnapshotOptions snapshot;
    double every = 10;          ///< [s]
    int first_frame = 0;        ///< number in the name of frame 0
    std::string init = "none";  ///< what identifies the file of the first air
};

struct RunRecord {
    std::vector<RunValue> values;
    /// One line for each value that another one replaced at a checkpoint: "after 600 s: heat_flux = 0.03 -> 0.1"
    std::vector<std::string> changes;

    /// "name = value", one line each.
    std::string text() const;
};
RunRecord describe(const Parameters&, const Sounding&, const FramePlan&);

/// Compares the record of a checkpoint at `time` [s] with that of the run that continues from it. Without `change`
/// throws UsageError for the first difference. With it, differences of values that can change are added to `changes`
/// of `now`, after those of the checkpoint; throws UsageError for others. `path` begins the message.
void continue_record(const std::string& path, const RunRecord& before, double time, bool change, RunRecord& now);

}  // namespace vdbcloud::sim
