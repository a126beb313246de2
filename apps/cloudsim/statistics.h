#pragma once
// The tables of --series and --profiles.
#include "report.h"

#include "vdbcloud/sim/statistics.h"

#include <string>

namespace vdbcloud::app {

class StatisticsFiles {
public:
    /// A new run, or with `time` >= 0 [s] one that continues from a checkpoint whose bytes are `state`: tables keep the
    /// lines up to it. Throws IoError, and UsageError for a checkpoint with another --average.
    StatisticsFiles(const Options&, const Run&, double time, const std::string& state);

    bool wanted() const { return wanted_; }
    /// Takes a sample and writes it. `last`: of the run, whose last period may be shorter.
    void add(sim::Simulation&, const sim::Budget&, bool last);
    /// Bytes for the checkpoint.
    std::string state() const;
    int samples() const { return samples_; }

private:
    void write_profiles();

    sim::ProfileMeans means_;
    bool wanted_, averages_;
    int samples_ = 0;
    double spacing_;  // of levels [m]
    std::optional<LineFile> series_, profiles_;
};

}  // namespace vdbcloud::app
