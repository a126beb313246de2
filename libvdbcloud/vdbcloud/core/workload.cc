#include "vdbcloud/core/workload.h"

#include "vdbcloud/core/unit_cost_table.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace vdbcloud {

namespace {

struct Table {
    std::string machine;
    std::vector<UnitCost> rows;

    /// Lines "event nanoseconds # meaning" and one "machine: name".
    Table()
    {
        std::istringstream lines(unit_cost_table());
        for (std::string line; std::getline(lines, line);) {
            const std::string said = "machine: ";
            if (line.compare(0, said.size(), said) == 0) machine = line.substr(said.size());
            std::istringstream words(line);
            UnitCost row;
            char hash = 0;
            if (!(words >> row.event >> row.nanoseconds >> hash) || hash != '#') continue;
            std::getline(words >> std::ws, row.meaning);
            rows.push_back(row);
        }
    }
};

const Table& table()
{
    static const Table read;
    return read;
}

const UnitCost& row_of(const std::string& event)
{
    const auto& rows = table().rows;
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const UnitCost& row) { return row.event == event; });
    if (found == rows.end()) throw std::invalid_argument("data/unit_costs.txt has no row '" + event + "'");
    return *found;
}

}  // namespace

const std::vector<UnitCost>& unit_costs() { return table().rows; }
const std::string& unit_cost_machine() { return table().machine; }

void Workload::add(const std::string& event, double count)
{
    row_of(event);
    if (count > 0) events_[event] += count;
}

Workload& Workload::operator+=(const Workload& other)
{
    for (const auto& [event, count] : other.events_) events_[event] += count;
    return *this;
}

double Workload::of(const std::string& event) const
{
    const auto found = events_.find(event);
    return found == events_.end() ? 0 : found->second;
}

double Workload::seconds() const
{
    double sum = 0;
    for (const auto& [event, count] : events_) sum += count * row_of(event).nanoseconds;
    return 1e-9 * sum;
}

}  // namespace vdbcloud
