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
    /// Writes the file of --netcdf, if there is one, with this history of command lines.
    void finish(const std::string& history) const;
    /// Bytes for the checkpoint.
    std::string state() const;
    int samples() const { return samples_; }

private:
    /// A table whose lines begin with a time: those up to `last` stay, and the headings.
    class Table {
    public:
        void open(const std::string& path, const std::string& heading, double last);
        explicit operator bool() const { return bool(file_); }
        void write(const std::vector<double>& values);
        const std::vector<std::vector<double>>& lines() const { return lines_; }

    private:
        std::optional<LineFile> file_;
        std::vector<std::vector<double>> lines_;
    };
    void write_profiles();

    sim::ProfileMeans means_;
    bool wanted_, averages_;
    int samples_ = 0;
    size_t levels_;
    double spacing_;  // of levels [m]
    std::string netcdf_;
    Table series_, profiles_;
};

}  // namespace vdbcloud::app
