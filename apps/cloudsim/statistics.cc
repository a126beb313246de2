#include "statistics.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/exchange/netcdf_tables.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>

namespace vdbcloud::app {

namespace {

std::string decimal(double value)
{
    if (std::isnan(value)) return "nan";  // without a sign
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

std::vector<double> numbers_of(const std::string& line)
{
    std::vector<double> values;
    for (const char* at = line.c_str(); *at;) {
        char* end = nullptr;
        values.push_back(std::strtod(at, &end));
        if (end == at) return {};
        at = *end == ',' ? end + 1 : end;
    }
    return values;
}

/// Columns of profiles before those of profile_columns().
const sim::StatisticsColumn places[] = {{"time_start", "s", "start of the period"},
                                        {"time_end", "s", "end of the period"},
                                        {"samples", "", "samples of the period"},
                                        {"z", "m", "height of cell centres"},
                                        {"z_face", "m", "height of lower faces"}};
constexpr size_t place_count = std::size(places);

/// Adds the lines of the series.
void add_series(NetcdfTables& to, const std::vector<std::vector<double>>& lines)
{
    const size_t time = to.dimensions.size();
    to.dimensions.emplace_back("time", lines.size());
    for (size_t c = 0; c < sim::series_columns().size(); ++c) {
        const sim::StatisticsColumn& column = sim::series_columns()[c];
        NetcdfColumn values{column.name, column.unit, column.meaning, {time}, {}};
        for (const auto& line : lines) values.values.push_back(line[c]);
        to.columns.push_back(std::move(values));
    }
}

/// Adds the lines of profiles, `levels` of them a period.
void add_profiles(NetcdfTables& to, const std::vector<std::vector<double>>& lines, size_t levels)
{
    const size_t period = to.dimensions.size(), z = period + 1, z_face = period + 2;
    to.dimensions.insert(to.dimensions.end(), {{"period", lines.size() / levels}, {"z", levels}, {"z_face", levels}});
    for (size_t c = 0; c < place_count; ++c) {
        NetcdfColumn values{places[c].name,
                            places[c].unit,
                            places[c].meaning,
                            {c < 3    ? period
                             : c == 3 ? z
                                      : z_face},
                            {}};
        for (size_t n = 0; n < (c < 3 ? lines.size() / levels : levels); ++n)
            values.values.push_back(lines[c < 3 ? n * levels : n][c]);
        to.columns.push_back(std::move(values));
    }
    for (size_t c = 0; c < sim::profile_columns().size(); ++c) {
        const sim::StatisticsColumn& column = sim::profile_columns()[c];
        NetcdfColumn values{column.name, column.unit, column.meaning, {period, column.at_face ? z_face : z}, {}};
        for (const auto& line : lines) values.values.push_back(line[place_count + c]);
        to.columns.push_back(std::move(values));
    }
}

}  // namespace

StatisticsFiles::StatisticsFiles(const Options& o, const Run& run, double time, const std::string& state)
    : means_(run.average), wanted_(!o.series.empty() || !o.profiles.empty()), averages_(!o.profiles.empty()),
      levels_(size_t(run.preset.parameters.lattice.n[2])), spacing_(run.preset.parameters.lattice.h[2]),
      netcdf_(o.netcdf)
{
    double periods = time < 0 ? -1 : time - 1e-9;  // start of the last period that the table keeps [s]
    if (averages_ && !state.empty()) {
        try {
            means_.restore(state, levels_);
        } catch (const InputError& error) {
            throw UsageError(o.resume + ": " + error.what());
        }
        const auto& open_period = means_.current();
        const bool complete = open_period.end >= open_period.start + run.average * (1 - 1e-9);
        periods = open_period.start - (complete ? 0 : 1e-9 * run.average);
    }
    series_.open(o.series, headings("", sim::series_columns()), time < 0 ? -1 : time * (1 + 1e-9));
    std::string first;
    for (const sim::StatisticsColumn& place : places) first += (first.empty() ? "" : ",") + place.heading();
    profiles_.open(o.profiles, headings(first, sim::profile_columns()), periods);
}

void StatisticsFiles::add(sim::Simulation& sim, const sim::Budget& budget, bool last)
{
    const sim::Sample sample = sim::take_sample(sim, budget);
    ++samples_;
    if (series_) series_.write(sample.series);
    if (!averages_ || !(budget.time > 0)) return;
    if (means_.add(budget.time, sample.profiles) || last) write_profiles();
}

std::string StatisticsFiles::state() const { return averages_ ? means_.bytes() : std::string(); }

void StatisticsFiles::write_profiles()
{
    const auto& period = means_.current();
    for (size_t k = 0; k < period.mean[0].size(); ++k) {
        std::vector<double> line{period.start, period.end, double(period.samples), (double(k) + 0.5) * spacing_,
                                 double(k) * spacing_};
        for (const auto& column : period.mean) line.push_back(column[k]);
        profiles_.write(line);
    }
}

void StatisticsFiles::finish(const std::string& history) const
{
    if (netcdf_.empty()) return;
    NetcdfTables tables;
    tables.attributes = {{"title", "Statistics of levels and of the box, of cloudsim"}, {"history", history}};
    if (!series_.lines().empty()) add_series(tables, series_.lines());
    if (!profiles_.lines().empty()) add_profiles(tables, profiles_.lines(), levels_);
    write_netcdf(netcdf_, tables);
}

void StatisticsFiles::Table::open(const std::string& path, const std::string& heading, double last)
{
    if (path.empty()) return;
    bool headed = false;
    file_.emplace(path, "table", [&](const std::string& line) {
        const bool is_heading = !headed && line == heading;
        const std::vector<double> values = is_heading ? std::vector<double>() : numbers_of(line);
        const bool keeps = last >= 0 && (is_heading || (headed && !values.empty() && values[0] <= last));
        headed = headed || (keeps && is_heading);
        if (keeps && !is_heading) lines_.push_back(values);
        return keeps;
    });
    if (!headed) file_->write(heading);
}

void StatisticsFiles::Table::write(const std::vector<double>& values)
{
    std::string line;
    for (const double value : values) line += (line.empty() ? "" : ",") + decimal(value);
    file_->write(line);
    lines_.push_back(numbers_of(line));
}

}  // namespace vdbcloud::app
