#include "statistics.h"

#include "vdbcloud/core/error.h"

#include <cstdio>
#include <cstdlib>

namespace vdbcloud::app {

namespace {

std::string decimal(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

/// Headings of a table: `first`, then those of its columns.
std::string headings(const std::string& first, const std::vector<sim::StatisticsColumn>& columns)
{
    std::string line = first;
    for (const sim::StatisticsColumn& column : columns) line += (line.empty() ? "" : ",") + column.heading();
    return line;
}

/// A table whose lines begin with a time: those up to `last` stay, and the headings.
void open(std::optional<LineFile>& file, const std::string& path, const std::string& heading, double last)
{
    if (path.empty()) return;
    bool headed = false;
    file.emplace(path, "table", [&](const std::string& line) {
        char* end = nullptr;
        const double time = std::strtod(line.c_str(), &end);
        const bool is_heading = !headed && line == heading,
                   keeps = last >= 0 && (is_heading || (headed && time <= last));
        headed = headed || (keeps && is_heading);
        return keeps;
    });
    if (!headed) file->write(heading);
}

}  // namespace

StatisticsFiles::StatisticsFiles(const Options& o, const Run& run, double time, const std::string& state)
    : means_(run.average), wanted_(!o.series.empty() || !o.profiles.empty()), averages_(!o.profiles.empty()),
      spacing_(run.preset.parameters.lattice.h[2])
{
    double periods = time < 0 ? -1 : time - 1e-9;  // start of the last period that the table keeps [s]
    if (averages_ && !state.empty()) {
        try {
            means_.restore(state, size_t(run.preset.parameters.lattice.n[2]));
        } catch (const InputError& error) {
            throw UsageError(o.resume + ": " + error.what());
        }
        const auto& open_period = means_.current();
        const bool complete = open_period.end >= open_period.start + run.average * (1 - 1e-9);
        periods = open_period.start - (complete ? 0 : 1e-9 * run.average);
    }
    open(series_, o.series, headings("", sim::series_columns()), time < 0 ? -1 : time * (1 + 1e-9));
    open(profiles_, o.profiles, headings("time_start[s],time_end[s],samples,z[m],z_face[m]", sim::profile_columns()),
         periods);
}

void StatisticsFiles::add(sim::Simulation& sim, const sim::Budget& budget, bool last)
{
    const sim::Sample sample = sim::take_sample(sim, budget);
    ++samples_;
    if (series_) {
        std::string line;
        for (const double value : sample.series) line += (line.empty() ? "" : ",") + decimal(value);
        series_->write(line);
    }
    if (!averages_ || !(budget.time > 0)) return;
    if (means_.add(budget.time, sample.profiles) || last) write_profiles();
}

std::string StatisticsFiles::state() const { return averages_ ? means_.bytes() : std::string(); }

void StatisticsFiles::write_profiles()
{
    const auto& period = means_.current();
    const std::string begin =
        decimal(period.start) + "," + decimal(period.end) + "," + std::to_string(period.samples) + ",";
    for (size_t k = 0; k < period.mean[0].size(); ++k) {
        std::string line = begin + decimal((double(k) + 0.5) * spacing_) + "," + decimal(double(k) * spacing_);
        for (const auto& column : period.mean) line += "," + decimal(column[k]);
        profiles_->write(line);
    }
}

}  // namespace vdbcloud::app
